#include "model/joint_motion.h"

namespace trunnion {

Matrix6d joint_twist(const KinematicChain& chain, std::size_t index, const Situation& s) {
  Eigen::Isometry3d frame = chain.r_from_joint(index, s.at);
  if (chain.rotary_joints()[index].side == Side::workpiece) return adjoint(frame);
  // The tool side travels with the linear axes: its frames stand where the commanded tip puts them.
  const Eigen::Vector3d tip_at_zero = chain.r_from_t(s.at) * Eigen::Vector3d(0, 0, -s.tool_length_mm);
  frame.pretranslate(s.point_r_mm - tip_at_zero);
  return -adjoint(frame);
}

Vector6d joint_rotation(const KinematicChain& chain, std::size_t index, const Situation& s) {
  Vector6d turn = Vector6d::Zero();
  turn.tail<3>() = chain.rotary_joints()[index].direction;
  return joint_twist(chain, index, s) * turn;
}

}  // namespace trunnion
