#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "kinematics/indexed_position.h"
#include "kinematics/machine.h"

namespace trunnion {

/// One rotary joint of a chain.
struct RotaryJoint {
  char letter;
  Side side;
  Eigen::Vector3d direction;  ///< unit vector in R at A = C = 0
  Eigen::Vector3d origin_mm;  ///< a point of its line (Axis::origin_mm)
};

/// The nominal forward kinematics of a five-axis machine, for any serial order of its two rotary axes, on either side.
///
/// Workpiece side, rotary joints 1..n from R outward to the table:
///   r_from_w = T(o1) R1 T(o2 - o1) R2 … T(-on),
/// so that W coincides with R at A = C = 0 (field: Ibaraki, Iritani & Matsushita 2010, Eq. 3 without errors).
/// Tool side alike, from the tool's reference point: the tip of a tool of length L stands at
///   tip_r = XYZ + r_from_t (0, 0, -L),  its axis along r_from_t.linear() e_z.
class KinematicChain {
 public:
  explicit KinematicChain(const Machine& machine);

  /// Workpiece frame W to reference frame R, mm.
  Eigen::Isometry3d r_from_w(IndexedPosition position) const;
  /// Tool frame to R with the linear axes at zero, mm; identity where the tool side has no rotary axis.
  Eigen::Isometry3d r_from_t(IndexedPosition position) const;

  /// The rotary joints: those of the workpiece side first, each side from R outward.
  const std::vector<RotaryJoint>& rotary_joints() const { return joints_; }
  /// The nominal frame in which the errors of joint `index` stand: at its origin, before its own motion, carried by the
  /// joints nearer to R (error before motion, Eq. 3). On the tool side with the linear axes at zero.
  Eigen::Isometry3d r_from_joint(std::size_t index, IndexedPosition position) const;
  /// The motion of joint `index` about its own line.
  Eigen::Matrix3d motion(std::size_t index, IndexedPosition position) const;
  /// Index into rotary_joints() of the tilting (A or B) and of the turning (C) axis.
  std::size_t tilt_index() const { return tilt_; }
  std::size_t turn_index() const { return 1 - tilt_; }
  bool turn_carries_tilt() const;  ///< whether C stands nearer to R than A on the same side
  bool tilt_carries_turn() const;  ///< whether A stands nearer to R than C on the same side, as on a trunnion

  /// Whether the table carries a rotary axis, and whether the tool does.
  bool has_rotary(Side side) const;

 private:
  std::vector<RotaryJoint> joints_;
  std::size_t tilt_ = 0;
};

}  // namespace trunnion
