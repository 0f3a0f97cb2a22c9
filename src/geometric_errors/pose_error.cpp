#include "geometric_errors/pose_error.h"

#include <algorithm>
#include <cmath>

namespace trunnion {

Eigen::Isometry3d transform(const PoseError& error) {
  using Eigen::AngleAxisd, Eigen::Vector3d;
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.linear() =
      (AngleAxisd(error.rotation_rad.x(), Vector3d::UnitX()) * AngleAxisd(error.rotation_rad.y(), Vector3d::UnitY()) *
       AngleAxisd(error.rotation_rad.z(), Vector3d::UnitZ()))
          .toRotationMatrix();
  result.translation() = error.translation_mm;
  return result;
}

PoseError pose_error(const Eigen::Isometry3d& transform) {
  const Eigen::Matrix3d r = transform.linear();
  PoseError error;
  error.translation_mm = transform.translation();
  error.rotation_rad = {std::atan2(-r(1, 2), r(2, 2)), std::asin(std::clamp(r(0, 2), -1.0, 1.0)),
                        std::atan2(-r(0, 1), r(0, 0))};
  return error;
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Matrix6d adjoint(const Eigen::Isometry3d& r_from_j) {
  Matrix6d ad = Matrix6d::Zero();
  ad.topLeftCorner<3, 3>() = r_from_j.linear();
  ad.bottomRightCorner<3, 3>() = r_from_j.linear();
  ad.topRightCorner<3, 3>() = cross_matrix(r_from_j.translation()) * r_from_j.linear();
  return ad;
}

Eigen::Vector3d displacement_mm(const PoseError& error, const Eigen::Vector3d& p_mm) {
  // (R - I) p, with R - I formed from sin and 1 - cos so that nothing is lost to cancellation.
  const Eigen::Vector3d& w = error.rotation_rad;
  const auto turn = [](const Eigen::Vector3d& axis, double angle, const Eigen::Vector3d& v) {
    const double half = std::sin(0.5 * angle);
    const Eigen::Vector3d across = axis.cross(v);
    return Eigen::Vector3d(std::sin(angle) * across + 2 * half * half * axis.cross(across));
  };
  const Eigen::Vector3d by_z = turn(Eigen::Vector3d::UnitZ(), w.z(), p_mm);
  const Eigen::Vector3d by_y = by_z + turn(Eigen::Vector3d::UnitY(), w.y(), p_mm + by_z);
  return error.translation_mm + by_y + turn(Eigen::Vector3d::UnitX(), w.x(), p_mm + by_y);
}

Eigen::Matrix<double, 3, 6> displacement_jacobian(const Eigen::Vector3d& p_mm) {
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian.leftCols<3>().setIdentity();
  jacobian.rightCols<3>() = -cross_matrix(p_mm);
  return jacobian;
}

}  // namespace trunnion
