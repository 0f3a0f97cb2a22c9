#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "discovery/closure.h"
#include "kinematics/machine.h"

namespace trunnion {

/// What the outcome of a search means for a cone frustum that is to be cut, by its envelope on the planned path.
/// `before` is by the rotary maps alone, `after` by all that was found. `not_corrected`: cut as programmed.
/// `corrected`: cut on the machine as it was found to be, after a correction by each of the two.
/// {"not_corrected": {"before", "after"}, "corrected": {"before", "after"}}, each {"roundness_um": largest over the
/// heights (LSC), "form_um"}; what the piece and the job leave unknown is added to `notes`. Reads both files (the job's
/// name may be empty) and adds them to `inputs`. Throws InputError, and RangeError for a piece beyond the probed tilts.
nlohmann::json piece_outlook(const Machine& machine, const ClosureResult& result, const std::string& piece_file,
                             const std::string& job_file, std::vector<std::string>& inputs,
                             std::vector<std::string>& notes);

std::string piece_outlook_text(const nlohmann::json& outlook);

}  // namespace trunnion
