#include "kinematics/kinematic_chain.h"

#include <algorithm>

namespace trunnion {

KinematicChain::KinematicChain(const Machine& machine) {
  const auto add = [&](const Joint& joint) {
    const Axis& axis = machine.axes.at(joint.letter);
    if (axis.rotary()) joints_.push_back({joint.letter, joint.side, axis.direction.normalized(), axis.origin_mm});
  };
  const std::vector<Joint>& order = machine.structure.joints;
  // The code runs from the workpiece to the tool: on the workpiece side R's end comes last, on the tool side first.
  std::for_each(order.rbegin(), order.rend(), [&](const Joint& j) {
    if (j.side == Side::workpiece) add(j);
  });
  std::for_each(order.begin(), order.end(), [&](const Joint& j) {
    if (j.side == Side::tool) add(j);
  });
  tilt_ = joints_.at(0).letter == 'C' ? 1 : 0;
}

Eigen::Matrix3d KinematicChain::motion(std::size_t index, IndexedPosition position) const {
  const Angle angle = index == tilt_ ? position.a : position.c;
  return Eigen::AngleAxisd(angle.in_radians(), joints_[index].direction).toRotationMatrix();
}

Eigen::Isometry3d KinematicChain::r_from_joint(std::size_t index, IndexedPosition position) const {
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < index; ++i) {
    if (joints_[i].side != joints_[index].side) continue;
    frame.translate(joints_[i].origin_mm).rotate(motion(i, position)).translate(-joints_[i].origin_mm);
  }
  return frame.translate(joints_[index].origin_mm);
}

namespace {

Eigen::Isometry3d side_transform(const KinematicChain& chain, Side side, IndexedPosition position) {
  const std::vector<RotaryJoint>& joints = chain.rotary_joints();
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (joints[i].side != side) continue;
    frame.translate(joints[i].origin_mm).rotate(chain.motion(i, position)).translate(-joints[i].origin_mm);
  }
  return frame;
}

}  // namespace

Eigen::Isometry3d KinematicChain::r_from_w(IndexedPosition position) const {
  return side_transform(*this, Side::workpiece, position);
}

Eigen::Isometry3d KinematicChain::r_from_t(IndexedPosition position) const {
  return side_transform(*this, Side::tool, position);
}

bool KinematicChain::has_rotary(Side side) const {
  return std::ranges::any_of(joints_, [&](const RotaryJoint& joint) { return joint.side == side; });
}

bool KinematicChain::turn_carries_tilt() const { return joints_[0].side == joints_[1].side && tilt_ == 1; }

bool KinematicChain::tilt_carries_turn() const { return joints_[0].side == joints_[1].side && tilt_ == 0; }

}  // namespace trunnion
