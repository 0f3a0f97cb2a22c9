#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "compensation/axis_correction.h"
#include "compensation/profile.h"
#include "compensation/working_volume.h"

namespace trunnion {

/// One file of a table set: its path below the set's folder, and all of its text.
struct TableFile {
  std::string name;
  std::string text;
  friend bool operator==(const TableFile&, const TableFile&) = default;
};

/// What the user chose.
struct TableOptions {
  std::string date;                  ///< as given, stands in every header; empty: none
  Angle tilt_spacing, turn_spacing;  ///< between nodes; zero: chosen for the error
  Length tool_length;                ///< that tables with Z as argument assume
};

/// What is to be compensated, and on what.
struct CompensationTask {
  const Machine& machine;
  const Model& model;
  KinematicChain chain;
  WorkingVolume volume;
  TableOptions options;
  Profile profile;
  std::string model_hash;
  CompensationTask(const Machine& machine, const Model& model, const TableOptions& options,
                   const ProfileQuestions& questions);
};

/// How a set is written: `refine` times more nodes than the spacing asks for, and numbers rounded as the format has
/// them or in full. Only what stands on a control is {1, true}; the others tell what spacing and rounding cost, and
/// heed no limits of the control.
struct Emission {
  int refine = 1;
  bool quantised = true;
  bool for_the_control() const { return refine == 1 && quantised; }
};

/// A control: how a model is projected on what its files can say, and what it does with such files. `emit` and `play`
/// share no sign: the one is written from what errors mean, the other from what the control is documented to do.
struct Controller {
  std::string_view name;
  std::string_view title;
  /// What of a machine's errors its files cannot say, for people.
  std::string_view cannot_hold;
  ProfileQuestions questions;
  /// Node spacings to try, coarse to fine, and what the distance of nodes may cost (rms).
  std::vector<Angle> spacings;
  Length spacing_loss = Length::micrometres(0.05);
  bool by_tables = true;  ///< corrections are tables' values, whose slopes are limited
  /// The files, named as on a load-ready set. Throws RangeError where a limit of the control would be exceeded.
  std::function<std::vector<TableFile>(const CompensationTask&, Angle spacing, Emission)> emit;
  /// Reads files back and plays the control. Throws InputError for what the control would refuse.
  std::function<std::unique_ptr<PlayedCompensation>(const std::vector<TableFile>&, const CompensationTask&)> play;
  /// Where the files go, which machine data, in which order, and how to undo it: Markdown.
  std::function<std::string(const CompensationTask&, const std::vector<TableFile>&)> loading;
  /// Ends of the names of files that take no comments: what they are, only their names and LOADING.md can say.
  std::vector<std::string_view> no_comments;
  /// Small tables that settle the open questions; may be empty.
  std::function<std::vector<TableFile>(const CompensationTask&)> commissioning;
};

/// All controllers, by the names of CONTRACT.
const std::vector<Controller>& controllers();
/// Throws UsageError naming the nearest.
const Controller& controller_named(const std::string& name);

/// Throws ModelError for a word of [profile] that no controller asks for, naming the nearest of `controller`; what
/// stands in tables below [profile] is the user's.
void refuse_unknown_keys(const Controller& controller, const Machine& machine);

/// The numbers of the five axes on the control by the profile (axis_number_X …). Throws ModelError where two are alike.
std::map<char, long> axis_numbers(const CompensationTask& task);

/// "0123456789abcdef", a fingerprint (FNV-1a, 64 bit) of the machine's effects as the model file writes them.
std::string model_fingerprint(const Model& model);

/// "Middle-size trunnion, serial 0001, model 0123456789abcdef, 2026-11-23": what every header says.
std::string provenance(const CompensationTask& task);

/// What a draft says of itself.
inline constexpr std::string_view kNotLoadReady = "DRAFT, NOT LOAD-READY";
/// The first lines of a file that takes comments behind `mark`: whose it is and, while a question is open, that it is a
/// draft.
std::string comment_header(const CompensationTask& task, std::string_view mark);

}  // namespace trunnion
