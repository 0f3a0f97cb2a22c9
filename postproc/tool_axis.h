#pragma once

#include <Eigen/Core>
#include <vector>

#include "kinematics/kinematic_chain.h"

namespace trunnion {

/// Rotary positions that hold the tool along a direction of the workpiece.
struct AxisSolution {
  IndexedPosition at;
  bool turn_free = false;  ///< the direction is along C: any C will do, `at` has the one that was asked for
};

/// The nominal rotary positions, none, one or two, at which the tool axis (from tip to spindle) lies along the unit
/// vector `axis_w` of W: r_from_w u = r_from_t e_z. With the two lines l1, l2 and angles this is R(l1) R(l2) p = q, the
/// second of the subproblems of Paden and Kahan. C is the one nearest to `turn_near`; where any will do, that itself.
std::vector<AxisSolution> rotary_positions_for(const KinematicChain& chain, const Eigen::Vector3d& axis_w,
                                               Angle turn_near);

/// The nominal tool axis in W, a unit vector.
Eigen::Vector3d tool_axis_w(const KinematicChain& chain, IndexedPosition at);

}  // namespace trunnion
