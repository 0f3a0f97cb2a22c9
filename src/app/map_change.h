#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "compensation/working_volume.h"

namespace trunnion {

/// What the search for missing effects changed at one corner of the working volume, over the tilts and turns of that
/// volume; lengths um.
struct CornerChange {
  Eigen::Vector3d corner_mm;            ///< of R
  double map_rms = 0, map_max = 0;      ///< of the rotary maps alone: what they no longer have to explain
  double model_rms = 0, model_max = 0;  ///< of all that is compensated
  IndexedPosition worst;                ///< where model_max is met
};
/// At the eight corners, `before` against `after`, both of them at time 0, 20 deg C and positive senses of motion.
std::vector<CornerChange> change_at_corners(const Model& before, const Model& after, const WorkingVolume& volume);

nlohmann::json map_change_json(const std::vector<CornerChange>& changes, char tilt_letter);

}  // namespace trunnion
