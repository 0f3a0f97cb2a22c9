#include "postproc/correction.h"

#include <cmath>

namespace trunnion {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDerivativeStep_rad =
    1e-4;  // errors change over tenths of a radian: 1e-9 of them is lost to curvature
constexpr double kConverged_rad = 1e-12;
constexpr int kMostSteps = 8;  // two do unless the errors are absurd

/// `v` turned by `angle` about the unit vector `axis` (Rodrigues).
Vector3d turned(const Vector3d& v, const Vector3d& axis, double angle) {
  const double s = std::sin(angle), h = std::sin(0.5 * angle);
  return v + s * axis.cross(v) + 2 * h * h * axis.cross(axis.cross(v));
}

Eigen::Matrix3d rotation(const Vector3d& rotation_rad) {
  return transform(PoseError{.rotation_rad = rotation_rad}).linear();
}

/// `value` for |value| << `limit`, `limit` at most, without a corner between.
double saturated(double value, double limit) {
  if (limit <= 0) return 0;
  const double ratio2 = (value / limit) * (value / limit);
  const double ratio8 = ratio2 * ratio2 * ratio2 * ratio2;
  return value / std::pow(1 + ratio8, 1.0 / 8);
}

/// The tool axis and the wanted axis near one programmed rotary position, the errors linear in (dA, dC).
class AxisMismatch {
 public:
  AxisMismatch(const KinematicChain& chain, IndexedPosition at, const Vector3d& error, const Vector3d& error_by_a,
               const Vector3d& error_by_c)
      : error_(error), error_by_a_(error_by_a), error_by_c_(error_by_c) {
    tool_ = chain.r_from_t(at).linear().col(2);
    for (std::size_t i = 0; i < 2; ++i) {
      const RotaryJoint& joint = chain.rotary_joints()[i];
      lines_[i] = chain.r_from_joint(i, at).linear() * joint.direction;
      of_workpiece_[i] = joint.side == Side::workpiece;
    }
    tilt_ = chain.tilt_index();
    // At right angles to the tool axis, where mismatches are seen.
    across_ = Matrix32::Zero();
    across_.col(0) = tool_.unitOrthogonal();
    across_.col(1) = tool_.cross(across_.col(0));
  }

  /// v - z across the tool axis, rad.
  Vector2d mismatch(const Vector2d& dq) const {
    const Vector3d wanted = rotation(error_ + error_by_a_ * dq[0] + error_by_c_ * dq[1]) * moved(tool_, dq, true);
    return across_.transpose() * (wanted - moved(tool_, dq, false));
  }

  /// d(mismatch)/d(dA, dC) of the nominal machine at dq = 0: a C parallel to the tool moves nothing.
  Matrix2d nominal_jacobian() const {
    Matrix2d jacobian;
    for (std::size_t i = 0; i < 2; ++i) {
      const Vector3d sweep = lines_[i].cross(tool_);
      jacobian.col(i == tilt_ ? 0 : 1) = across_.transpose() * (of_workpiece_[i] ? sweep : Vector3d(-sweep));
    }
    return jacobian;
  }

  /// The same with the errors' own derivative.
  Matrix2d jacobian() const {
    Matrix2d jacobian = nominal_jacobian();
    jacobian.col(0) += across_.transpose() * error_by_a_.cross(tool_);
    jacobian.col(1) += across_.transpose() * error_by_c_.cross(tool_);
    return jacobian;
  }

 private:
  using Matrix32 = Eigen::Matrix<double, 3, 2>;

  /// The tool axis direction carried along by the joints of one side: the inner joint turns first.
  Vector3d moved(Vector3d v, const Vector2d& dq, bool workpiece) const {
    for (std::size_t i = 2; i-- > 0;)
      if (of_workpiece_[i] == workpiece) v = turned(v, lines_[i], dq[i == tilt_ ? 0 : 1]);
    return v;
  }

  Vector3d error_, error_by_a_, error_by_c_;
  Vector3d tool_;
  Vector3d lines_[2];
  bool of_workpiece_[2];
  std::size_t tilt_;
  Matrix32 across_;
};

}  // namespace

PoseError Corrector::error_at(const Commanded& programmed, IndexedPosition position, const Vector3d& tip_r_mm) const {
  Situation situation;
  situation.at = position;
  situation.point_r_mm = tip_r_mm;
  situation.tilt_sense = programmed.tilt_sense;
  situation.turn_sense = programmed.turn_sense;
  situation.tool_length_mm = settings_.tool_length_mm;
  return field_.at(situation);
}

Vector3d Corrector::nominal_tip_w(const Commanded& programmed) const {
  if (settings_.tcp == ToolCentrePoint::on) return programmed.xyz_mm;
  return chain_.r_from_w(programmed.rotary).inverse() * nominal_tip_r(programmed);
}

Vector3d Corrector::nominal_tip_r(const Commanded& programmed) const {
  if (settings_.tcp == ToolCentrePoint::on) return chain_.r_from_w(programmed.rotary) * programmed.xyz_mm;
  if (!chain_.has_rotary(Side::tool)) return programmed.xyz_mm;
  const Vector3d tool(0, 0, -settings_.tool_length_mm);
  return programmed.xyz_mm + chain_.r_from_t(programmed.rotary) * tool - tool;
}

RotaryCorrection Corrector::rotary(const Commanded& programmed) const {
  if (settings_.orientation == Orientation::as_programmed) return {};
  const Vector3d tip = nominal_tip_r(programmed);
  const IndexedPosition at = programmed.rotary;
  const Vector3d error = error_at(programmed, at, tip).rotation_rad;
  const Angle step = Angle::radians(kDerivativeStep_rad);
  const Vector3d by_a = (error_at(programmed, {at.a + step, at.c}, tip).rotation_rad - error) / kDerivativeStep_rad;
  const Vector3d by_c = (error_at(programmed, {at.a, at.c + step}, tip).rotation_rad - error) / kDerivativeStep_rad;
  const AxisMismatch axes(chain_, at, error, by_a, by_c);

  // Stationary point J~^T m(q) + diag(0, lambda^2) dq = 0 by Newton with the full derivative. J~ is the nominal one, so
  // that a C parallel to the tool keeps its programmed value.
  const double lambda = std::sin(settings_.damping.in_radians());
  const Matrix2d gradient = axes.nominal_jacobian().transpose();
  const Matrix2d slope = axes.jacobian();
  Matrix2d normal = gradient * slope;
  normal(1, 1) += lambda * lambda;
  const Matrix2d inverse = normal.inverse();
  Vector2d dq = Vector2d::Zero();
  for (int i = 0; i < kMostSteps; ++i) {
    Vector2d descent = gradient * axes.mismatch(dq);
    descent[1] += lambda * lambda * dq[1];
    const Vector2d change = inverse * descent;
    dq -= change;
    if (change.cwiseAbs().maxCoeff() < kConverged_rad) break;
  }
  // The tilting axis, undamped, at the C that is left.
  dq[1] = saturated(dq[1], settings_.largest_rotary_change.in_radians());
  for (int i = 0; i < kMostSteps; ++i) {
    const double change = gradient.row(0).dot(axes.mismatch(dq)) / normal(0, 0);
    dq[0] -= change;
    if (std::abs(change) < kConverged_rad) break;
  }
  return {Angle::radians(dq[0]), Angle::radians(dq[1]), Angle::radians(axes.mismatch(dq).norm())};
}

Corrector::Linear Corrector::linear(const Commanded& programmed, IndexedPosition rotary) const {
  const Eigen::Isometry3d table = chain_.r_from_w(rotary);
  const bool moved = !(rotary == programmed.rotary);
  const bool on = settings_.tcp == ToolCentrePoint::on;
  const Vector3d tip_w = nominal_tip_w(programmed);
  const Vector3d tip_r = on || moved ? Vector3d(table * tip_w) : nominal_tip_r(programmed);
  Linear result;
  result.error = error_at(programmed, rotary, tip_r);
  const Vector3d deviation = displacement_mm(result.error, tip_r);
  result.deviation_mm = deviation.norm();
  if (on) {
    result.change_mm = table.linear().transpose() * deviation;
  } else {
    result.change_mm = deviation;
    if (moved) {
      result.change_mm += tip_r - nominal_tip_r(programmed);
      const Vector3d tool(0, 0, -settings_.tool_length_mm);
      if (chain_.has_rotary(Side::tool))
        result.change_mm -= (chain_.r_from_t(rotary).linear() - chain_.r_from_t(programmed.rotary).linear()) * tool +
                            chain_.r_from_t(rotary).translation() - chain_.r_from_t(programmed.rotary).translation();
    }
  }
  return result;
}

Angle Corrector::tilt_error(const Commanded& programmed, IndexedPosition rotary) const {
  const Vector3d wanted_w =
      chain_.r_from_w(programmed.rotary).linear().transpose() * chain_.r_from_t(programmed.rotary).linear().col(2);
  const Eigen::Isometry3d table = chain_.r_from_w(rotary);
  const PoseError error = error_at(programmed, rotary, table * nominal_tip_w(programmed));
  const Vector3d wanted = rotation(error.rotation_rad) * (table.linear() * wanted_w);
  const Vector3d tool = chain_.r_from_t(rotary).linear().col(2);
  return Angle::radians(std::atan2(wanted.cross(tool).norm(), wanted.dot(tool)));
}

double Corrector::tip_error_mm(const Commanded& programmed, const Commanded& commanded) const {
  return (linear(programmed, commanded.rotary).change_mm + programmed.xyz_mm - commanded.xyz_mm).norm();
}

}  // namespace trunnion
