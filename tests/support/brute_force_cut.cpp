#include "support/brute_force_cut.h"

#include <cmath>

namespace trunnion::testing {

bool cuts(const Cutter& cutter, const ToolInWorkpiece& tool, const Eigen::Vector3d& point_w_mm) {
  const Eigen::Vector3d off = point_w_mm - tool.tip_w_mm;
  const double up = off.dot(tool.axis_w), out = off.cross(tool.axis_w).norm();
  if (up < 0 || out > cutter.radius_mm) return false;
  const double beyond = out - (cutter.radius_mm - cutter.corner_mm), below = cutter.corner_mm - up;
  return beyond <= 0 || below <= 0 || std::sqrt(beyond * beyond + below * below) <= cutter.corner_mm;
}

double material_left_mm(const Cutter& cutter, const std::vector<ToolInWorkpiece>& tools,
                        const Eigen::Vector3d& point_w_mm, const Eigen::Vector3d& normal_w, double depth_mm) {
  constexpr double kStep_mm = 0.05;
  double left = 1;  // what is looked at above the point
  for (const ToolInWorkpiece& tool : tools) {
    const auto cut_at = [&](double t) { return cuts(cutter, tool, point_w_mm + t * normal_w); };
    double outside = -depth_mm;
    if (cut_at(outside)) return outside;
    while (outside < left && !cut_at(outside + kStep_mm)) outside += kStep_mm;
    if (outside >= left) continue;
    double inside = outside + kStep_mm;
    for (int i = 0; i < 40; ++i) {
      const double middle = (outside + inside) / 2;
      (cut_at(middle) ? inside : outside) = middle;
    }
    left = std::min(left, inside);
  }
  return left;
}

}  // namespace trunnion::testing
