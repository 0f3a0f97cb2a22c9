#pragma once

#include "compensation/controller.h"

namespace trunnion {

// The five-axis transformation of a SINUMERIK, generic type 40 (both rotary axes turn the workpiece): offset vectors
// and axis directions as channel machine data MD24500 to MD24572. By them X, Y, Z follow the location errors.

constexpr const char* kTrafo5File = "TRAFO5.INI";

/// Whether the machine has such a transformation, and its profile lets it be set.
bool sets_trafo5(const CompensationTask& task);
/// The machine data with the axes where `location`, location errors as an effect, has them.
TableFile trafo5_file(const CompensationTask& task, const Effect& location, Emission emission);
/// The chain in which a control with these data believes. Throws InputError for vectors that do not close, or are not
/// about as long as 1 where a direction is wanted.
KinematicChain read_trafo5(const TableFile& file, const CompensationTask& task);
/// What to do with the file, for LOADING.md.
std::string trafo5_loading(const CompensationTask& task);
/// What is open about it.
std::vector<ProfileItem> trafo5_questions();

}  // namespace trunnion
