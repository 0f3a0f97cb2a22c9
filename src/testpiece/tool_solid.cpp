#include "testpiece/tool_solid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace trunnion {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Signed distance to the solid from distance `rho` to its axis and height `s` above the tip, and its change along a
/// direction with parts `rho_dot` and `s_dot`.
struct Distance {
  double value, change;
};
Distance distance_to(const ToolSolid& solid, double rho, double s, double rho_dot, double s_dot) {
  const double out = rho - (solid.radius_mm - solid.corner_mm), down = solid.corner_mm - s;
  if (out > 0 && down > 0) {
    const double d = std::hypot(out, down);
    return {d - solid.corner_mm, (out * rho_dot - down * s_dot) / d};
  }
  if (out > down) return {out - solid.corner_mm, rho_dot};
  return {down - solid.corner_mm, -s_dot};
}

}  // namespace

ToolSolid solid_of(const FlankTool& tool) {
  return {0.5 * tool.diameter.in_millimetres(), tool.corner_radius.in_millimetres()};
}

std::optional<RayInterval> ray_through(const ToolSolid& solid, const ToolInWorkpiece& tool, const Vector3d& point,
                                       const Vector3d& direction) {
  const Vector3d from_tip = point - tool.tip_w_mm;
  const double s0 = from_tip.dot(tool.axis_w), s_dot = direction.dot(tool.axis_w);
  const Vector3d w = from_tip - s0 * tool.axis_w, v = direction - s_dot * tool.axis_w;
  // |w + t v| = radius, each root without cancellation.
  const double a = v.squaredNorm(), b = w.dot(v), c = w.squaredNorm() - solid.radius_mm * solid.radius_mm;
  RayInterval t{-kInfinity, kInfinity};
  if (a > 1e-24) {
    const double discriminant = b * b - a * c;
    if (discriminant < 0) return std::nullopt;
    const double q = b < 0 ? -b + std::sqrt(discriminant) : -b - std::sqrt(discriminant);
    const double one = q / a, other = q != 0 ? c / q : one;
    t = {std::min(one, other), std::max(one, other)};
  } else if (c > 0) {
    return std::nullopt;
  }
  if (std::abs(s_dot) > 1e-15) {  // above the tip
    const double bottom = -s0 / s_dot;
    if (s_dot > 0)
      t.in_mm = std::max(t.in_mm, bottom);
    else
      t.out_mm = std::min(t.out_mm, bottom);
  } else if (s0 < 0) {
    return std::nullopt;
  }
  if (t.in_mm > t.out_mm) return std::nullopt;
  if (solid.corner_mm <= 0 || t.in_mm == -kInfinity || s0 + t.in_mm * s_dot >= solid.corner_mm) return t;
  // The rounded edge stands back from where the ray enters the square one. The distance to a convex solid is convex
  // along a line: Newton's steps from outside close in on the entry without passing it.
  for (int step = 0; step < 100; ++step) {
    const Vector3d off = w + t.in_mm * v;
    const double rho = off.norm();
    const Distance d = distance_to(solid, rho, s0 + t.in_mm * s_dot, rho > 0 ? off.dot(v) / rho : 0, s_dot);
    if (d.value < 1e-14) return t;
    if (d.change >= 0) return std::nullopt;
    t.in_mm -= d.value / d.change;
    if (t.in_mm > t.out_mm) return std::nullopt;
  }
  return t;
}

}  // namespace trunnion
