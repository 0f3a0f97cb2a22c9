#pragma once

#include <string>
#include <string_view>

#include "io/job_file.h"
#include "kinematics/kinematic_chain.h"
#include "postproc/motion.h"

namespace trunnion {

/// The dialect of a program that begins with `head`: unmistakable signs, then the machine's controller; "" where
/// neither tells it.
std::string dialect_of(std::string_view head, const Machine& machine);

/// How programs of a dialect are read for a machine and a job: where the program does not say whether the tip is held,
/// the machine file does. `chain` must outlive it.
ScanSettings scan_settings(const std::string& dialect, const Machine& machine, const KinematicChain& chain,
                           const Job& job);

}  // namespace trunnion
