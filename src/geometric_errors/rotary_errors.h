#pragma once

#include "geometric_errors/pose_error.h"
#include "kinematics/kinematic_chain.h"

namespace trunnion {

/// The twelve rotary errors at one indexed position: the six of the tilting axis (EXA … ECA) and the six of C (EXC …
/// ECC).
struct RotaryErrors {
  PoseError tilt;
  PoseError turn;
  friend RotaryErrors operator-(const RotaryErrors& a, const RotaryErrors& b) {
    return {a.tilt - b.tilt, a.turn - b.turn};
  }
  friend bool operator==(const RotaryErrors&, const RotaryErrors&) = default;
};

/// Where the tool is, for rotary axes on its side: the tip in R and the tool's length.
struct ToolPlace {
  Eigen::Vector3d tip_r_mm = Eigen::Vector3d::Zero();
  double length_mm = 0;
};

/// r_T_w with errors, exact: each workpiece-side joint contributes T(o) E(e) R T(-o), error before motion (Eq. 3).
Eigen::Isometry3d actual_r_from_w(const KinematicChain& chain, IndexedPosition position, const RotaryErrors& errors);

/// The error of the workpiece relative to the tool, taken at R's origin, of a machine whose rotary errors are `here` at
/// `position` and `reference` at A = C = 0, where the workpiece was set up:
///   workpiece side, exact:  T(Delta) = T(A,C) T(0,0)^-1 T~(A,C)^-1          (CONTRACT; Eq. 6 and 10)
///   minus the tool side, to first order, at the tip, alike relative to the reference pose: what the tip and axis had
///   wrong there was set up with the workpiece and turns with the table.
PoseError relative_pose_error(const KinematicChain& chain, IndexedPosition position, const RotaryErrors& here,
                              const RotaryErrors& reference, const ToolPlace& tool);

/// d(relative_pose_error)/d(here) and d/d(reference) at zero errors, each 6 x 12: columns EXA … ECA, EXC … ECC.
struct RelativeErrorJacobian {
  Eigen::Matrix<double, 6, 12> here;
  Eigen::Matrix<double, 6, 12> reference;
};
RelativeErrorJacobian relative_error_jacobian(const KinematicChain& chain, IndexedPosition position,
                                              const ToolPlace& tool);

}  // namespace trunnion
