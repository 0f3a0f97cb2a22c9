#pragma once

#include <Eigen/Core>
#include <memory>

/// The factorisations of Eigen that the parts need, for dense matrices of any size, compiled once: their templates take
/// ten seconds a size, and a compiler that meets them in every source builds twice as long.
namespace trunnion {

/// A = V diag(d) V^T of a symmetric A (n x n, the lower triangle is read), eigenvalues ascending.
class SymmetricEigen {
 public:
  explicit SymmetricEigen(const Eigen::Ref<const Eigen::MatrixXd>& a);
  const Eigen::VectorXd& eigenvalues() const { return values_; }
  const Eigen::MatrixXd& eigenvectors() const { return vectors_; }  ///< n x n, a column each

 private:
  Eigen::VectorXd values_;
  Eigen::MatrixXd vectors_;
};

/// What the factorisations share: x = A^-1 b for a vector or for the columns of a matrix.
template <class Factor>
class Solves {
 public:
  template <class Derived>
  auto solve(const Eigen::MatrixBase<Derived>& b) const {
    const auto& factor = static_cast<const Factor&>(*this);
    if constexpr (Derived::ColsAtCompileTime == 1)
      return factor.solve_vector(b);
    else
      return factor.solve_matrix(b);
  }
};

/// A = L L^T of a positive definite A (n x n, the lower triangle is read).
class Cholesky : public Solves<Cholesky> {
 public:
  explicit Cholesky(const Eigen::Ref<const Eigen::MatrixXd>& a);
  bool definite() const { return definite_; }  ///< what follows has a meaning only then
  const Eigen::MatrixXd& lower() const { return lower_; }
  double half_log_determinant() const { return lower_.diagonal().array().log().sum(); }
  /// L^-1 b.
  template <class Derived>
  auto half_solve(const Eigen::MatrixBase<Derived>& b) const {
    if constexpr (Derived::ColsAtCompileTime == 1)
      return half_solve_vector(b);
    else
      return half_solve_matrix(b);
  }
  Eigen::MatrixXd inverse() const;
  Eigen::VectorXd inverse_diagonal() const;  ///< of A^-1, at a third of its cost
  Eigen::VectorXd solve_vector(const Eigen::Ref<const Eigen::VectorXd>& b) const;
  Eigen::MatrixXd solve_matrix(const Eigen::Ref<const Eigen::MatrixXd>& b) const;

 private:
  Eigen::MatrixXd lower_inverse() const;
  Eigen::VectorXd half_solve_vector(const Eigen::Ref<const Eigen::VectorXd>& b) const;
  Eigen::MatrixXd half_solve_matrix(const Eigen::Ref<const Eigen::MatrixXd>& b) const;

  Eigen::MatrixXd lower_;
  bool definite_ = false;
};

/// P A P^T = L diag(d) L^T of a semidefinite A (n x n, the lower triangle is read), pivoted.
class PivotedCholesky : public Solves<PivotedCholesky> {
 public:
  PivotedCholesky();
  explicit PivotedCholesky(const Eigen::Ref<const Eigen::MatrixXd>& a);
  PivotedCholesky(PivotedCholesky&&) noexcept;
  PivotedCholesky& operator=(PivotedCholesky&&) noexcept;
  ~PivotedCholesky();
  const Eigen::VectorXd& pivots() const;  ///< d
  Eigen::MatrixXd root() const;           ///< R with R R^T = A, pivots below zero taken for zero
  Eigen::VectorXd solve_vector(const Eigen::Ref<const Eigen::VectorXd>& b) const;
  Eigen::MatrixXd solve_matrix(const Eigen::Ref<const Eigen::MatrixXd>& b) const;

 private:
  struct Factors;
  std::unique_ptr<Factors> factors_;
};

/// The shortest x of those that bring A x (m x n, of any rank) nearest to b.
class LeastSquares : public Solves<LeastSquares> {
 public:
  /// Columns whose pivots are below `threshold` of the largest are taken for dependent; that of the rounding unless
  /// said.
  explicit LeastSquares(const Eigen::Ref<const Eigen::MatrixXd>& a, double threshold = 0);
  LeastSquares(LeastSquares&&) noexcept;
  LeastSquares& operator=(LeastSquares&&) noexcept;
  ~LeastSquares();
  Eigen::Index rank() const;
  Eigen::VectorXd solve_vector(const Eigen::Ref<const Eigen::VectorXd>& b) const;
  Eigen::MatrixXd solve_matrix(const Eigen::Ref<const Eigen::MatrixXd>& b) const;

 private:
  struct Factors;
  std::unique_ptr<Factors> factors_;
};

/// Orthonormal columns (m x rank) that span those of A (m x n), by QR with column pivots below `threshold` of the
/// largest left out.
Eigen::MatrixXd orthonormal_columns(const Eigen::Ref<const Eigen::MatrixXd>& a, double threshold);

/// A = U diag(s) V^T (m x n), thin: k = min(m, n) columns, s descending.
struct SingularValues {
  Eigen::MatrixXd u;  ///< m x k
  Eigen::VectorXd s;
  Eigen::MatrixXd v;  ///< n x k
};
SingularValues singular_values(const Eigen::Ref<const Eigen::MatrixXd>& a);

}  // namespace trunnion
