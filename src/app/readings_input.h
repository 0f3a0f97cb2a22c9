#pragma once

#include <string>

#include "app/command.h"
#include "kinematics/machine.h"
#include "probing/observation.h"

namespace trunnion {

/// The readings of an observations file (io/observation_file.h), its progress told.
ObservationSet observations_input(const std::string& path, const Machine& machine, const Talk& talk);

/// The readings of a probing program's log (io/probe_program.h), its progress told.
ObservationSet probe_log_input(const std::string& path, const Machine& machine, const Talk& talk);

}  // namespace trunnion
