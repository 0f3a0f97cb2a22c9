#include "geometric_errors/rotary_errors.h"

namespace trunnion {
namespace {

using Matrix612 = Eigen::Matrix<double, 6, 12>;

/// The twist that the errors of the joints on `side` make at R's origin, to first order; `offset_mm` is where the
/// linear axes carry that side's frames to.
Matrix612 side_twist(const KinematicChain& chain, Side side, IndexedPosition position,
                     const Eigen::Vector3d& offset_mm) {
  Matrix612 twist = Matrix612::Zero();
  for (std::size_t i = 0; i < chain.rotary_joints().size(); ++i) {
    if (chain.rotary_joints()[i].side != side) continue;
    Eigen::Isometry3d frame = chain.r_from_joint(i, position);
    frame.pretranslate(offset_mm);
    twist.middleCols<6>(i == chain.tilt_index() ? 0 : 6) = adjoint(frame);
  }
  return twist;
}

const IndexedPosition kReference{};

/// The tool side's share, at the tip: displacement of the tip and rotation of the tool, relative to the reference pose.
RelativeErrorJacobian tool_twist(const KinematicChain& chain, IndexedPosition position, const ToolPlace& tool) {
  const Eigen::Vector3d gauge_line(0, 0, -tool.length_mm);
  // Twists taken at the tip: shift the frames so that the tip is the origin.
  const auto at_tip = [&](IndexedPosition p) {
    return side_twist(chain, Side::tool, p, Eigen::Vector3d(-(chain.r_from_t(p) * gauge_line)));
  };
  // From the tip to R's origin: D_0 = D_tip - theta x tip.
  Matrix6d to_origin = Matrix6d::Identity();
  to_origin.topRightCorner<3, 3>() = cross_matrix(tool.tip_r_mm);
  // What the head had wrong at the reference pose was set up with the workpiece: a table turns it along.
  const Eigen::Matrix3d table = chain.r_from_w(position).linear();
  Matrix612 reference = at_tip(kReference);
  reference.topRows<3>() = table * reference.topRows<3>();
  reference.bottomRows<3>() = table * reference.bottomRows<3>();
  return {to_origin * at_tip(position), -to_origin * reference};
}

}  // namespace

Eigen::Isometry3d actual_r_from_w(const KinematicChain& chain, IndexedPosition position, const RotaryErrors& errors) {
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  const std::vector<RotaryJoint>& joints = chain.rotary_joints();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (joints[i].side != Side::workpiece) continue;
    frame.translate(joints[i].origin_mm);
    frame = frame * transform(i == chain.tilt_index() ? errors.tilt : errors.turn);
    frame.rotate(chain.motion(i, position)).translate(-joints[i].origin_mm);
  }
  return frame;
}

PoseError relative_pose_error(const KinematicChain& chain, IndexedPosition position, const RotaryErrors& here,
                              const RotaryErrors& reference, const ToolPlace& tool) {
  PoseError error;
  if (chain.has_rotary(Side::workpiece)) {
    const Eigen::Isometry3d actual = actual_r_from_w(chain, position, here) *
                                     actual_r_from_w(chain, kReference, reference).inverse(Eigen::Isometry) *
                                     chain.r_from_w(position).inverse(Eigen::Isometry);
    error = pose_error(actual);
  }
  if (chain.has_rotary(Side::tool)) {
    const RelativeErrorJacobian j = tool_twist(chain, position, tool);
    const auto stacked = [](const RotaryErrors& e) {
      return (Eigen::Matrix<double, 12, 1>() << e.tilt.vector(), e.turn.vector()).finished();
    };
    error = error - PoseError::from_vector(j.here * stacked(here) + j.reference * stacked(reference));
  }
  return error;
}

RelativeErrorJacobian relative_error_jacobian(const KinematicChain& chain, IndexedPosition position,
                                              const ToolPlace& tool) {
  RelativeErrorJacobian j;
  j.here = side_twist(chain, Side::workpiece, position, Eigen::Vector3d::Zero());
  j.reference =
      -adjoint(chain.r_from_w(position)) * side_twist(chain, Side::workpiece, kReference, Eigen::Vector3d::Zero());
  if (chain.has_rotary(Side::tool)) {
    const RelativeErrorJacobian t = tool_twist(chain, position, tool);
    j.here -= t.here;
    j.reference -= t.reference;
  }
  return j;
}

}  // namespace trunnion
