#include "discovery/projection.h"

#include "linear_algebra/factors.h"

namespace trunnion {
namespace {

/// An orthonormal basis of the column space of `m`, columns below 1e-9 of the largest pivot dropped; so are those that
/// are shorter than 1e-7 of `norms`, which had them in full: what is left of them is rounding.
Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& m, const Eigen::VectorXd& norms) {
  std::vector<Eigen::Index> kept;
  const Eigen::VectorXd left = m.colwise().norm().transpose();
  for (Eigen::Index k = 0; k < m.cols(); ++k)
    if (left[k] > 1e-7 * norms[k]) kept.push_back(k);
  if (kept.empty() || m.rows() == 0) return Eigen::MatrixXd(m.rows(), 0);
  // Columns to unit length first: um and urad differ by their levers only.
  const Eigen::MatrixXd scaled = m(Eigen::all, kept) * left(kept).cwiseInverse().asDiagonal();
  return orthonormal_columns(scaled, 1e-9);
}

}  // namespace

Projection::Projection(const std::vector<bool>& used) : mask_(static_cast<Eigen::Index>(used.size())) {
  for (std::size_t i = 0; i < used.size(); ++i) mask_[static_cast<Eigen::Index>(i)] = used[i] ? 1 : 0;
}

Eigen::MatrixXd Projection::apply(const Eigen::MatrixXd& z) const {
  return mask_.asDiagonal() * z - expanded(reduced(z));
}

void Projection::set_readings(const Eigen::VectorXd& y) {
  residual_ = apply(y);
  square_ = y.dot(residual_);
}

FreePoseProjection::FreePoseProjection(const ProjectionInput& input) : Projection(input.used) {
  const LinearProblem& problem = *input.problem;
  const auto n = static_cast<Eigen::Index>(problem.readings.size());
  rows_.resize(problem.poses.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    const Reading& reading = problem.readings[static_cast<std::size_t>(i)];
    // The points of a piece share no pose: free poses would explain each of them by itself.
    if (problem.poses[reading.pose].moving) mask_[i] = 0;
    if (mask_[i] > 0 && !problem.poses[reading.pose].reference) rows_[reading.pose].push_back(i);
  }
  for (const std::vector<Eigen::Index>& rows : rows_) {
    Eigen::MatrixXd block(static_cast<Eigen::Index>(rows.size()), 6);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const Reading& reading = problem.readings[static_cast<std::size_t>(rows[k])];
      block.row(static_cast<Eigen::Index>(k)) = reading.functional.transpose() / reading.sigma;
    }
    q_.push_back(orthonormal(block, block.colwise().norm().transpose()));
    pose_rank_ += q_.back().cols();
  }
  const auto unknowns = static_cast<Eigen::Index>(problem.unknowns.size());
  Eigen::MatrixXd border = Eigen::MatrixXd::Zero(n, unknowns + input.accepted.columns.cols());
  for (Eigen::Index i = 0; i < n; ++i) {
    const Reading& reading = problem.readings[static_cast<std::size_t>(i)];
    for (const auto& [k, u] : problem.terms_of(reading)) border(i, k) += u / reading.sigma;
  }
  if (input.accepted.columns.cols() > 0) border.rightCols(input.accepted.columns.cols()) = input.accepted.columns;
  border = mask_.asDiagonal() * border;
  border_ = Eigen::MatrixXd(n, 0);
  border_ = orthonormal(apply(border), border.colwise().norm().transpose());
  freedom_ = mask_.sum() - static_cast<double>(pose_rank_ + border_.cols());
  set_readings(input.y);
}

Eigen::MatrixXd FreePoseProjection::reduced(const Eigen::MatrixXd& z) const {
  Eigen::MatrixXd r(pose_rank_ + border_.cols(), z.cols());
  Eigen::Index at = 0;
  for (std::size_t p = 0; p < rows_.size(); ++p) {
    r.middleRows(at, q_[p].cols()).noalias() = q_[p].transpose() * z(rows_[p], Eigen::all);
    at += q_[p].cols();
  }
  // The border is orthogonal to the poses and zero where readings are out of use.
  r.bottomRows(border_.cols()).noalias() = border_.transpose() * z;
  return r;
}

Eigen::MatrixXd FreePoseProjection::expanded(const Eigen::MatrixXd& r) const {
  Eigen::MatrixXd z = border_ * r.bottomRows(border_.cols());
  Eigen::Index at = 0;
  for (std::size_t p = 0; p < rows_.size(); ++p) {
    if (q_[p].cols() > 0) z(rows_[p], Eigen::all) += q_[p] * r.middleRows(at, q_[p].cols());
    at += q_[p].cols();
  }
  return z;
}

SmoothProjection::SmoothProjection(const ProjectionInput& input, const SmoothDesign& design)
    : Projection(input.used), y_(input.y) {
  const Eigen::Index base = design.columns.cols(), extra = input.accepted.columns.cols();
  x_.resize(design.columns.rows(), base + extra);
  x_.leftCols(base) = design.columns;
  if (extra > 0) x_.rightCols(extra) = input.accepted.columns;
  Eigen::VectorXd precision(base + extra);
  precision << design.precision, input.accepted.precision;
  const Eigen::MatrixXd used = mask_.asDiagonal() * x_;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(base + extra, base + extra);
  normal.selfadjointView<Eigen::Lower>().rankUpdate(used.transpose());
  normal.diagonal() += precision;
  // Unknowns that no reading in use sees, and free columns alike in all readings, stay where they are.
  double free = 0;
  const double ridge = 1e-12 * normal.diagonal().maxCoeff();
  for (Eigen::Index k = 0; k < base + extra; ++k) {
    const bool is_free = precision[k] == 0;
    if (is_free) free += normal(k, k) > 0 ? 1 : 0;
    if (normal(k, k) <= 0) normal(k, k) = 1;
    if (is_free) normal(k, k) += std::min(ridge, 1e-9 * normal(k, k));
  }
  root_ = Cholesky(normal).lower();
  // Location errors are free as well, by their wide prior: eight columns.
  freedom_ = mask_.sum() - free - 8;
  set_readings(input.y);
  mean_ = root_.transpose().triangularView<Eigen::Upper>().solve(reduced(y_));
}

Eigen::MatrixXd SmoothProjection::reduced(const Eigen::MatrixXd& z) const {
  return reduced_products(x_.transpose() * (mask_.asDiagonal() * z));
}

Eigen::MatrixXd SmoothProjection::reduced_products(Eigen::MatrixXd xz) const {
  root_.triangularView<Eigen::Lower>().solveInPlace(xz);
  return xz;
}

Eigen::MatrixXd SmoothProjection::expanded(const Eigen::MatrixXd& r) const {
  return mask_.asDiagonal() * (x_ * root_.transpose().triangularView<Eigen::Upper>().solve(r));
}

SmoothProjection::Prediction SmoothProjection::predict(const std::vector<Eigen::Index>& rows) const {
  const Eigen::MatrixXd x = x_(rows, Eigen::all);
  return {y_(rows) - x * mean_, root_.triangularView<Eigen::Lower>().solve(x.transpose()).transpose()};
}

Eigen::VectorXd SmoothProjection::misfit() const { return y_ - x_ * mean_; }

}  // namespace trunnion
