#pragma once

#include <memory>
#include <string>
#include <vector>

#include "compensation/bare_readings.h"
#include "compensation/controller.h"
#include "kinematics/machine.h"

namespace trunnion {

/// The readings of `set` as the machine itself would have given them; `path` is the compensation that was switched on
/// while they were taken: a folder that `trunnion tables` wrote, or a model file. What was read is added to `inputs`.
/// Throws InputError for a path that is neither.
ObservationSet without_active(ObservationSet set, const std::string& path, const Machine& machine,
                              std::vector<std::string>& inputs);

/// The same for a model, and for a set of tables, that were read already. Throw RefusalError for another machine's.
ObservationSet without_active(ObservationSet set, const Model& model, const Machine& machine);
ObservationSet without_active(ObservationSet set, const std::vector<TableFile>& tables, const Machine& machine);

}  // namespace trunnion
