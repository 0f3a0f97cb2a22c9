#include "linear_algebra/factors.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>

namespace trunnion {

using Eigen::MatrixXd;
using Eigen::Ref;
using Eigen::VectorXd;

SymmetricEigen::SymmetricEigen(const Ref<const MatrixXd>& a) {
  if (a.rows() == 0) return;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(a);
  values_ = eigen.eigenvalues();
  vectors_ = eigen.eigenvectors();
}

// ---- Cholesky

Cholesky::Cholesky(const Ref<const MatrixXd>& a) {
  const Eigen::LLT<MatrixXd> factor(a);
  definite_ = factor.info() == Eigen::Success;
  lower_ = factor.matrixL();
}

namespace {
constexpr Eigen::Index kBlock = 32;  // columns at once, where a triangle's zeros are passed over
}

MatrixXd Cholesky::lower_inverse() const {
  const Eigen::Index n = lower_.rows();
  MatrixXd x = MatrixXd::Zero(n, n);
  for (Eigen::Index j = 0; j < n; j += kBlock) {
    const Eigen::Index wide = std::min(kBlock, n - j), below = n - j;
    auto columns = x.block(j, j, below, wide);
    columns.setIdentity();
    lower_.bottomRightCorner(below, below).triangularView<Eigen::Lower>().solveInPlace(columns);
  }
  return x;
}

MatrixXd Cholesky::inverse() const {
  const Eigen::Index n = lower_.rows();
  const MatrixXd x = lower_inverse();  // A^-1 = X^T X, and row k of X ends at column k
  MatrixXd inverse(n, n);
  for (Eigen::Index i = 0; i < n; i += kBlock) {
    const Eigen::Index wide = std::min(kBlock, n - i), below = n - i;
    inverse.block(i, 0, wide, i + wide).noalias() =
        x.block(i, i, below, wide).transpose() * x.block(i, 0, below, i + wide);
  }
  inverse.triangularView<Eigen::StrictlyUpper>() = inverse.transpose();
  return inverse;
}

VectorXd Cholesky::inverse_diagonal() const { return lower_inverse().colwise().squaredNorm().transpose(); }

VectorXd Cholesky::solve_vector(const Ref<const VectorXd>& b) const {
  VectorXd x = half_solve_vector(b);
  lower_.triangularView<Eigen::Lower>().transpose().solveInPlace(x);
  return x;
}

MatrixXd Cholesky::solve_matrix(const Ref<const MatrixXd>& b) const {
  MatrixXd x = half_solve_matrix(b);
  lower_.triangularView<Eigen::Lower>().transpose().solveInPlace(x);
  return x;
}

VectorXd Cholesky::half_solve_vector(const Ref<const VectorXd>& b) const {
  return lower_.triangularView<Eigen::Lower>().solve(b);
}

MatrixXd Cholesky::half_solve_matrix(const Ref<const MatrixXd>& b) const {
  return lower_.triangularView<Eigen::Lower>().solve(b);
}

// ---- PivotedCholesky

struct PivotedCholesky::Factors {
  Eigen::LDLT<MatrixXd> ldlt;
  VectorXd pivots;
};

PivotedCholesky::PivotedCholesky() = default;
PivotedCholesky::PivotedCholesky(PivotedCholesky&&) noexcept = default;
PivotedCholesky& PivotedCholesky::operator=(PivotedCholesky&&) noexcept = default;
PivotedCholesky::~PivotedCholesky() = default;

PivotedCholesky::PivotedCholesky(const Ref<const MatrixXd>& a) : factors_(std::make_unique<Factors>()) {
  factors_->ldlt.compute(a);
  factors_->pivots = factors_->ldlt.vectorD();
}

const VectorXd& PivotedCholesky::pivots() const { return factors_->pivots; }

MatrixXd PivotedCholesky::root() const {
  const MatrixXd lower = factors_->ldlt.matrixL();
  const VectorXd d = factors_->pivots.cwiseMax(0).cwiseSqrt();
  return factors_->ldlt.transpositionsP().transpose() * MatrixXd(lower * d.asDiagonal());
}

VectorXd PivotedCholesky::solve_vector(const Ref<const VectorXd>& b) const { return factors_->ldlt.solve(b); }
MatrixXd PivotedCholesky::solve_matrix(const Ref<const MatrixXd>& b) const { return factors_->ldlt.solve(b); }

// ---- LeastSquares

struct LeastSquares::Factors {
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> orthogonal;
};

LeastSquares::LeastSquares(LeastSquares&&) noexcept = default;
LeastSquares& LeastSquares::operator=(LeastSquares&&) noexcept = default;
LeastSquares::~LeastSquares() = default;

LeastSquares::LeastSquares(const Ref<const MatrixXd>& a, double threshold) : factors_(std::make_unique<Factors>()) {
  if (threshold > 0) factors_->orthogonal.setThreshold(threshold);
  factors_->orthogonal.compute(a);
}

Eigen::Index LeastSquares::rank() const { return factors_->orthogonal.rank(); }
VectorXd LeastSquares::solve_vector(const Ref<const VectorXd>& b) const { return factors_->orthogonal.solve(b); }
MatrixXd LeastSquares::solve_matrix(const Ref<const MatrixXd>& b) const { return factors_->orthogonal.solve(b); }

// ---- the others

MatrixXd orthonormal_columns(const Ref<const MatrixXd>& a, double threshold) {
  Eigen::ColPivHouseholderQR<MatrixXd> qr(a);
  qr.setThreshold(threshold);
  return qr.householderQ() * MatrixXd::Identity(a.rows(), qr.rank());
}

SingularValues singular_values(const Ref<const MatrixXd>& a) {
  const Eigen::JacobiSVD<MatrixXd> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

}  // namespace trunnion
