#pragma once

#include <string>
#include <vector>

#include "compensation/verification.h"

// What comes with tables for people, and what the files of a draft are called.

namespace trunnion {

/// "AXIS_A.COM" as a draft, "AXIS_A.DRAFT.COM", and the other way round.
std::string draft_name(const std::string& name);
std::string final_name(std::string name);

/// A set as it will stand in its folder.
struct SetDocuments {
  const Controller& controller;
  const CompensationTask& task;
  const Verification& verification;
  const std::vector<TableFile>& tables;
  const std::vector<TableFile>& commissioning;
};

/// LOADING.md: what the set does, where its files go, in which order, how to undo it; of a draft, why it is one.
std::string loading_text(const SetDocuments& set);
/// COMMISSIONING.md: the tests that answer the open questions, and how the answers are entered.
std::string commissioning_text(const SetDocuments& set);

}  // namespace trunnion
