#pragma once

#include "identification/free_pose_fit.h"
#include "identification/smooth_fit.h"
#include "model/effects/rotary_error_map.h"

namespace trunnion {

/// The grid that probed poses make: stations of A and C that most of the others share, and which pose stands at a node.
struct PoseGrid {
  std::vector<Angle> a_stations, c_stations;
  std::vector<std::ptrdiff_t> pose_at;  ///< [i * c_stations.size() + j]: index of the pose, -1 where none was probed
  std::vector<std::size_t> off_grid;    ///< poses that stand at no node: check poses
  std::size_t missing() const;
};
/// Scattered poses, which make no grid, get stations of their own at regular steps.
PoseGrid find_grid(const std::vector<PoseGroup>& poses);

/// Pose errors as maps after Eq. (12) and (13), for rotary axes on the workpiece side: the tilting axis' errors make
/// the mean of C's over the C stations zero (Eq. 1). A node where a freedom was not seen is left out of the mean, and
/// its entries that the freedom reaches are marked unseen. A node that was not probed is taken from `smooth`.
RotaryMapContent map_from_poses(const LinearProblem& problem, const PoseGrid& grid, const FreePoseFit& fit,
                                const SmoothFit& smooth);

/// The smooth surface at the nodes, split after Eq. (1), with its covariance.
RotaryMapContent map_from_surface(const LinearProblem& problem, const PoseGrid& grid, const SmoothFit& smooth);

/// Makes the smooth surface what holds between the nodes, without its unseen constants.
void set_smooth_surface(RotaryMapContent& content, const LinearProblem& problem, const SmoothFit& smooth);

}  // namespace trunnion
