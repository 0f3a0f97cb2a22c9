#include "postproc/motion.h"

#include <cmath>

namespace trunnion {

AxisValues between(const AxisValues& from, const AxisValues& to, double s) {
  AxisValues at;
  for (std::size_t i = 0; i < kAxes; ++i) at[i] = s >= 1 ? to[i] : from[i] + s * (to[i] - from[i]);
  return at;
}

AxisValues with_arc(const Arc* arc, AxisValues at, double s) {
  if (arc == nullptr || s >= 1) return at;
  const double angle = s * arc->sweep_rad;
  const Eigen::Vector3d place = arc->centre +
                                (1 + s * arc->growth) * (std::cos(angle) * arc->along + std::sin(angle) * arc->across) +
                                s * arc->rise;
  for (std::size_t i = 0; i < 3; ++i) at[i] = place[static_cast<Eigen::Index>(i)];
  return at;
}

}  // namespace trunnion
