#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "compensation/controller.h"

// The files of a HEIDENHAIN TNC: a .COM table over each rotary axis, the .CMA that assigns them, rows of the kinematics
// table.

namespace trunnion::tnc {

constexpr std::size_t kMostEntries = 256;  // of a .COM table
constexpr std::size_t kMostInserted = 95;  // 100 less the MachAxis lines of five axes
constexpr const char* kKinematicsFile = "KINEMATICS_COMP.TXT";
constexpr const char* kAssignmentFile = "CONFIG.CMA";

inline std::string com_file(char axis) { return std::string("AXIS_") + axis + ".COM"; }

/// The control with these files in it. Throws InputError for what it would not take.
std::unique_ptr<PlayedCompensation> play(const std::vector<TableFile>& files, const CompensationTask& task);

}  // namespace trunnion::tnc
