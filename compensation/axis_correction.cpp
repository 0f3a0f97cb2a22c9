#include "compensation/axis_correction.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "model/joint_motion.h"

namespace trunnion {
namespace {

const double kDamping = std::sin(std::numbers::pi / 180);

/// Where the machine really goes for a command with a correction.
struct Reached {
  Eigen::Isometry3d r_from_w;  ///< actual, errors of the whole loop counted on the workpiece side
  Eigen::Isometry3d r_from_t;  ///< nominal, linear axes at zero
  Eigen::Vector3d tip_r_mm;
};

Situation corrected(const Situation& s, const AxisCorrection& correction) {
  Situation moved = s;
  moved.at = {s.at.a + Angle::radians(correction.tilt_rad), s.at.c + Angle::radians(correction.turn_rad)};
  return moved;
}

Reached reached(const Model& model, const KinematicChain& chain, const Situation& s, const AxisCorrection& correction) {
  Situation moved = corrected(s, correction);
  const Eigen::Vector3d tool(0, 0, -s.tool_length_mm);
  Reached r;
  r.r_from_t = chain.r_from_t(moved.at);
  r.tip_r_mm = s.point_r_mm + correction.linear_mm + r.r_from_t * tool - chain.r_from_t(s.at) * tool;
  moved.point_r_mm = r.tip_r_mm;
  r.r_from_w = transform(relative_error(model, moved)) * chain.r_from_w(moved.at);
  return r;
}

/// C's share saturates smoothly at the largest change of its word.
double saturated(double turn_rad, double cap_rad) {
  if (cap_rad <= 0) return 0;
  return turn_rad / std::pow(1 + std::pow(turn_rad / cap_rad, 8), 1.0 / 8);
}

}  // namespace

AxisCorrection& AxisCorrection::operator+=(const AxisCorrection& other) {
  linear_mm += other.linear_mm;
  tilt_rad += other.tilt_rad;
  turn_rad += other.turn_rad;
  return *this;
}

Remaining remaining(const Model& model, const KinematicChain& chain, const Situation& s,
                    const AxisCorrection& correction) {
  const Reached r = reached(model, chain, s, correction);
  const Eigen::Vector3d point_w = chain.r_from_w(s.at).inverse() * s.point_r_mm;
  const Eigen::Vector3d nominal_axis = chain.r_from_w(s.at).linear().transpose() * chain.r_from_t(s.at).linear().col(2);
  const Eigen::Vector3d actual_axis = r.r_from_w.linear().transpose() * r.r_from_t.linear().col(2);
  return {r.r_from_w * point_w - r.tip_r_mm, std::asin(std::min(1.0, nominal_axis.cross(actual_axis).norm()))};
}

AxisCorrection ideal_correction(const Model& model, const KinematicChain& chain, const CorrectionLimits& limits,
                                const Situation& s) {
  const Eigen::Vector3d axis_w = chain.r_from_w(s.at).linear().transpose() * chain.r_from_t(s.at).linear().col(2);
  AxisCorrection correction;
  double turn = 0;  // before saturation
  for (int step = 0; step < 4; ++step) {
    const Reached r = reached(model, chain, s, correction);
    // Tilt of the workpiece against the tool, as a small rotation; about the tool's axis itself nothing matters.
    const Eigen::Vector3d tool_axis = r.r_from_t.linear().col(2);
    const Eigen::Vector3d tilt = tool_axis.cross(r.r_from_w.linear() * axis_w);
    const Situation here = corrected(s, correction);
    const Eigen::Vector3d about_a = joint_rotation(chain, chain.tilt_index(), here).tail<3>();
    const Eigen::Vector3d about_c = joint_rotation(chain, chain.turn_index(), here).tail<3>();
    const auto across = [&](const Eigen::Vector3d& v) { return Eigen::Vector3d(v - v.dot(tool_axis) * tool_axis); };
    Eigen::Matrix<double, 3, 2> j;
    j << across(about_a), across(about_c);
    Eigen::Matrix2d normal = j.transpose() * j;
    normal(1, 1) += kDamping * kDamping;
    Eigen::Vector2d gradient = j.transpose() * tilt;
    gradient[1] += kDamping * kDamping * turn;
    const Eigen::Vector2d change = -(normal.inverse() * gradient);
    correction.tilt_rad += change[0];
    turn += change[1];
    correction.turn_rad = saturated(turn, limits.rotary_word.in_radians());
  }
  for (int step = 0; step < 3; ++step) correction.linear_mm += remaining(model, chain, s, correction).position_mm;
  return correction;
}

}  // namespace trunnion
