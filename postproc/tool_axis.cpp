#include "postproc/tool_axis.h"

#include <cmath>
#include <numbers>

namespace trunnion {
namespace {

using Eigen::Vector3d;

constexpr double kUpright = 1e-7;      // sine: C tells nothing about the tool axis
constexpr double kUnreachable = 1e-9;  // beyond rounding

/// The angle about the unit vector `line` that turns `from` into `to`, seen along it.
double angle_about(const Vector3d& line, const Vector3d& from, const Vector3d& to) {
  const Vector3d a = from - line * line.dot(from), b = to - line * line.dot(to);
  return std::atan2(line.dot(a.cross(b)), a.dot(b));
}

double nearest_turn(double angle, double near) {
  constexpr double turn = 2 * std::numbers::pi;
  return angle + turn * std::round((near - angle) / turn);
}

}  // namespace

Vector3d tool_axis_w(const KinematicChain& chain, IndexedPosition at) {
  return chain.r_from_w(at).linear().transpose() * chain.r_from_t(at).linear().col(2);
}

std::vector<AxisSolution> rotary_positions_for(const KinematicChain& chain, const Vector3d& axis_w, Angle turn_near) {
  // R(l1, q1) R(l2, q2) p = q, whichever side the joints are on.
  const auto& joints = chain.rotary_joints();
  const bool first_on_table = joints[0].side == Side::workpiece, second_on_table = joints[1].side == Side::workpiece;
  Vector3d l1, l2, p, q;
  double sign1 = 1, sign2 = 1;
  std::size_t outer = 0;
  if (first_on_table == second_on_table) {
    l1 = joints[0].direction, l2 = joints[1].direction;
    p = first_on_table ? axis_w : Vector3d::UnitZ();
    q = first_on_table ? Vector3d::UnitZ() : axis_w;
  } else {
    // One table axis turns u to where one head axis turns e_z: R(t, -q_t) R(w, q_w) u = e_z.
    outer = first_on_table ? 1 : 0;
    l1 = joints[outer].direction, l2 = joints[1 - outer].direction;
    sign1 = -1;
    p = axis_w, q = Vector3d::UnitZ();
  }
  const double cosine = l1.dot(l2), sine2 = 1 - cosine * cosine;
  const double alpha = (l1.dot(q) - cosine * l2.dot(p)) / sine2, beta = (l2.dot(p) - cosine * l1.dot(q)) / sine2;
  const double gamma2 = (1 - alpha * alpha - beta * beta - 2 * alpha * beta * cosine) / sine2;
  std::vector<AxisSolution> solutions;
  if (gamma2 < -kUnreachable) return solutions;
  const double gamma = std::sqrt(std::max(0.0, gamma2));
  for (const double side : {1.0, -1.0}) {
    const Vector3d z = alpha * l1 + beta * l2 + side * gamma * l1.cross(l2);
    const std::size_t inner = 1 - outer;
    double angle[2];
    AxisSolution solution;
    // An axis along what it is to turn does nothing.
    const auto turned = [&](std::size_t joint, const Vector3d& line, const Vector3d& from, const Vector3d& to,
                            double sign) {
      if (joint == chain.turn_index() && line.cross(from).norm() < kUpright) {
        solution.turn_free = true;
        return turn_near.in_radians();
      }
      return sign * angle_about(line, from, to);
    };
    angle[inner] = turned(inner, l2, p, z, sign2);
    angle[outer] = turned(outer, l1, z, q, sign1);
    angle[chain.turn_index()] = nearest_turn(angle[chain.turn_index()], turn_near.in_radians());
    solution.at = {Angle::radians(angle[chain.tilt_index()]), Angle::radians(angle[chain.turn_index()])};
    solutions.push_back(solution);
    if (gamma < kUpright || solution.turn_free) break;
  }
  return solutions;
}

}  // namespace trunnion
