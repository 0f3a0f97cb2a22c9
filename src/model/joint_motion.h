#pragma once

#include "geometric_errors/pose_error.h"
#include "kinematics/kinematic_chain.h"
#include "model/situation.h"

namespace trunnion {

/// First-order error of the workpiece relative to the tool, at R's origin, per radian by which rotary joint `index`
/// stands further in its own sense (about its `direction`) than commanded; mm/rad and rad/rad. Minus on the tool side.
Vector6d joint_rotation(const KinematicChain& chain, std::size_t index, const Situation& situation);

/// Alike for a twist given in the joint's frame (before its motion): Ad(Q, t), minus on the tool side, 6 x 6.
Matrix6d joint_twist(const KinematicChain& chain, std::size_t index, const Situation& situation);

}  // namespace trunnion
