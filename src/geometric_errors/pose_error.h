#pragma once

#include <Eigen/Geometry>

namespace trunnion {

/// Six components of a pose error, lengths (mm) before angles (rad), and what is linear in them.
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix6Xd = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// Six small errors of a pose: lengths at the origin of its frame, mm, and angles about its axes, rad.
///   T(e) = Tx Ty Tz Rx Ry Rz   (Ibaraki, Iritani & Matsushita 2010, Eq. 3 and 10)
struct PoseError {
  Eigen::Vector3d translation_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();

  static PoseError from_vector(const Vector6d& v) { return {v.head<3>(), v.tail<3>()}; }
  Vector6d vector() const { return (Vector6d() << translation_mm, rotation_rad).finished(); }

  PoseError& operator+=(const PoseError& other) {
    translation_mm += other.translation_mm;
    rotation_rad += other.rotation_rad;
    return *this;
  }
  friend PoseError operator+(PoseError a, const PoseError& b) { return a += b; }
  friend PoseError operator*(double factor, const PoseError& e) {
    return {factor * e.translation_mm, factor * e.rotation_rad};
  }
  friend PoseError operator-(const PoseError& a, const PoseError& b) { return a + -1.0 * b; }
  friend bool operator==(const PoseError& a, const PoseError& b) {
    return a.translation_mm == b.translation_mm && a.rotation_rad == b.rotation_rad;
  }
};

/// T(e), exact.
Eigen::Isometry3d transform(const PoseError& error);

/// The errors whose T(e) is `transform`, exact; the angle about Y lies within +-90 deg.
PoseError pose_error(const Eigen::Isometry3d& transform);

/// The first-order image in frame R of errors standing in frame j: rotation Q theta, translation Q D + t x Q theta,
/// that is Ad(Q, t) with r_from_j = (Q, t). The lever term matters where axes do not cross.
Matrix6d adjoint(const Eigen::Isometry3d& r_from_j);

/// `T(error) p - p`, exact: how a point of the displaced body moves, mm.
Eigen::Vector3d displacement_mm(const PoseError& error, const Eigen::Vector3d& p_mm);

/// d(displacement)/d(error) to first order, [I, -[p]x], 3 x 6.
Eigen::Matrix<double, 3, 6> displacement_jacobian(const Eigen::Vector3d& p_mm);

/// The cross-product matrix [v]x.
Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v);

}  // namespace trunnion
