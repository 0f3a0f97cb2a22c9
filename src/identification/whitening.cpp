#include "identification/whitening.h"

#include <cmath>

#include "linear_algebra/factors.h"

namespace trunnion {

Eigen::MatrixXd whitening(const Eigen::MatrixXd& covariance) {
  constexpr double kSpanned = 1e-9;
  const Eigen::Index n = covariance.rows();
  const Eigen::VectorXd unit =
      covariance.diagonal().unaryExpr([](double variance) { return variance > 0 ? 1 / std::sqrt(variance) : 0.0; });
  if (n == 0 || unit.maxCoeff() <= 0) return Eigen::MatrixXd::Zero(0, n);
  const SymmetricEigen eigen(unit.asDiagonal() * covariance * unit.asDiagonal());
  Eigen::Index first = 0;  // eigenvalues ascend
  while (eigen.eigenvalues()[first] <= kSpanned * eigen.eigenvalues()[n - 1]) ++first;
  return eigen.eigenvalues().tail(n - first).cwiseSqrt().cwiseInverse().asDiagonal() *
         eigen.eigenvectors().rightCols(n - first).transpose() * unit.asDiagonal();
}

Eigen::MatrixXd least_squares_gain(const Eigen::MatrixXd& design, const Eigen::MatrixXd& covariance,
                                   const Eigen::VectorXd& scale) {
  constexpr double kTold = 1e-9;  // of the best determined
  const Eigen::MatrixXd white = whitening(covariance);
  const Eigen::MatrixXd x = white * design * scale.asDiagonal();
  const PivotedCholesky normal(x.transpose() * x);
  if (normal.pivots().minCoeff() < kTold * normal.pivots().maxCoeff()) return {};
  return scale.asDiagonal() * normal.solve(x.transpose() * white);
}

}  // namespace trunnion
