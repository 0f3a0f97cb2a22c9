
#include "error.h"
#include "identification/linear_problem.h"
#include "linear_algebra/factors.h"

namespace trunnion {
namespace {

/// The rotation nearest to m in the Frobenius norm.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& m) {
  const SingularValues svd = singular_values(m);
  const Eigen::Matrix3d u = svd.u, v = svd.v;
  const Eigen::Vector3d signs(1, 1, (u * v.transpose()).determinant() < 0 ? -1 : 1);
  return u * signs.asDiagonal() * v.transpose();
}

}  // namespace

PoseMounting fit_pose_mounting(const ObservationSet& observations, const KinematicChain& chain) {
  // M_i = I T_i M: the rotations first, R_I^T R_Mi - R_i R_M = 0, linear in the entries of R_I^T and R_M.
  using Matrix18 = Eigen::Matrix<double, 18, 18>;
  Matrix18 normal = Matrix18::Zero();
  std::size_t count = 0;
  for (const Observation& row : observations.rows) {
    if (row.kind != ReadingKind::pose) continue;
    ++count;
    const Eigen::Matrix3d measured = row.orientation.toRotationMatrix();
    const Eigen::Matrix3d nominal = chain.r_from_w(row.at).linear();
    Eigen::Matrix<double, 9, 18> equation = Eigen::Matrix<double, 9, 18>::Zero();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) {
          equation(3 * i + j, 3 * i + k) += measured(k, j);     // (R_I^T)_ik (R_M)_kj
          equation(3 * i + j, 9 + 3 * k + j) -= nominal(i, k);  // (R_i)_ik (R_mount)_kj
        }
    normal += equation.transpose() * equation;
  }
  if (count < 3)
    throw InputError(observations.files.front(), std::to_string(count) + " poses found, three or more are wanted");
  const SymmetricEigen eigen(normal);
  if (eigen.eigenvalues()[1] < 1e-6 * eigen.eigenvalues()[17])
    throw InputError(observations.files.front(), "the poses turn about one axis only; both rotary axes must move");
  const Eigen::Matrix<double, 18, 1> v = eigen.eigenvectors().col(0);
  using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  Eigen::Matrix3d r_from_i = Eigen::Map<const RowMajor3>(v.data()), mount = Eigen::Map<const RowMajor3>(v.data() + 9);
  if (r_from_i.determinant() < 0) r_from_i = -r_from_i, mount = -mount;
  PoseMounting mounting;
  mounting.instrument_from_r.linear() = nearest_rotation(r_from_i).transpose();
  mounting.w_from_target.linear() = nearest_rotation(mount);

  // Then the translations: t_Mi = R_I (R_i t_M + t_i) + t_I.
  Eigen::MatrixXd a(static_cast<Eigen::Index>(3 * count), 6);
  Eigen::VectorXd b(static_cast<Eigen::Index>(3 * count));
  Eigen::Index k = 0;
  for (const Observation& row : observations.rows) {
    if (row.kind != ReadingKind::pose) continue;
    const Eigen::Isometry3d nominal = chain.r_from_w(row.at);
    const Eigen::Matrix3d r = mounting.instrument_from_r.linear();
    a.block<3, 3>(k, 0) = r * nominal.linear();
    a.block<3, 3>(k, 3).setIdentity();
    b.segment<3>(k) = row.position_mm - r * nominal.translation();
    k += 3;
  }
  const Eigen::VectorXd t = a.completeOrthogonalDecomposition().solve(b);
  mounting.w_from_target.translation() = t.head<3>();
  mounting.instrument_from_r.translation() = t.tail<3>();
  return mounting;
}

}  // namespace trunnion
