#include "testpiece/cone_frustum.h"

#include <cmath>

#include "error.h"

namespace trunnion {

Eigen::Isometry3d w_from_cone(const ConeFrustum& cone) {
  using Eigen::Vector3d;
  const double tilt = cone.tilt.in_radians(), azimuth = cone.tilt_azimuth.in_radians();
  const Vector3d axis(std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth), std::cos(tilt));
  Vector3d zero = Vector3d::UnitX() - axis.x() * axis;
  if (zero.norm() < 1e-6) throw ModelError("the cone's axis lies along X of W, which leaves phi without a zero");
  zero.normalize();
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  frame.linear() << zero, axis.cross(zero), axis;
  frame.translation() = cone.base_center_w_mm;
  return frame;
}

Length radius_at(const ConeFrustum& cone, Length h) {
  return 0.5 * cone.base_diameter - std::tan(cone.half_angle.in_radians()) * h;
}

ConePoint cone_point(const ConeFrustum& cone, const Eigen::Isometry3d& frame, Angle phi, Length h) {
  using Eigen::Vector3d;
  const Vector3d radial = frame.linear() * Vector3d(std::cos(phi.in_radians()), std::sin(phi.in_radians()), 0);
  const Vector3d axis = frame.linear().col(2);
  const double s = std::sin(cone.half_angle.in_radians()), c = std::cos(cone.half_angle.in_radians());
  return {frame.translation() + radius_at(cone, h).in_millimetres() * radial + h.in_millimetres() * axis,
          c * radial + s * axis, c * axis - s * radial};
}

}  // namespace trunnion
