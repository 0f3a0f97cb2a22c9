#include "linear_algebra/factors.h"

#include <gtest/gtest.h>

namespace trunnion {
namespace {

/// Symmetric, positive definite, with eigenvalues from 1 to n.
Eigen::MatrixXd definite(Eigen::Index n) {
  Eigen::MatrixXd turn = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index k = 0; k + 1 < n; ++k) {
    const double angle = 1 + .37 * static_cast<double>(k);
    Eigen::MatrixXd plane = Eigen::MatrixXd::Identity(n, n);
    plane.block<2, 2>(k, k) << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
    turn = turn * plane;
  }
  return turn * Eigen::VectorXd::LinSpaced(n, 1, static_cast<double>(n)).asDiagonal() * turn.transpose();
}

TEST(Cholesky, InverseOfAnySizeAndItsDiagonal) {
  for (const Eigen::Index n : {1, 2, 31, 32, 33, 64, 100}) {
    const Eigen::MatrixXd a = definite(n);
    const Cholesky factor(a);
    ASSERT_TRUE(factor.definite()) << n;
    const Eigen::MatrixXd inverse = factor.inverse();
    EXPECT_LT((a * inverse - Eigen::MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff(), 1e-12) << n;
    EXPECT_EQ(inverse, inverse.transpose()) << n;
    EXPECT_LT((factor.inverse_diagonal() - inverse.diagonal()).cwiseAbs().maxCoeff(), 1e-14) << n;
    EXPECT_LT((factor.solve(a) - Eigen::MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff(), 1e-12) << n;
  }
}

TEST(Cholesky, IndefiniteIsSaid) {
  Eigen::MatrixXd a = definite(40);
  a(39, 39) = -1;
  EXPECT_FALSE(Cholesky(a).definite());
}

}  // namespace
}  // namespace trunnion
