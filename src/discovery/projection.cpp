#include "discovery/projection.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>

namespace trunnion {
namespace {

/// An orthonormal basis of the column space of `m`, columns below 1e-9 of the largest pivot dropped.
Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& m) {
  if (m.cols() == 0 || m.rows() == 0) return Eigen::MatrixXd(m.rows(), 0);
  // Columns to unit length first: um and urad differ by their levers only.
  const Eigen::VectorXd norms = m.colwise().norm().transpose();
  if (norms.maxCoeff() <= 0) return Eigen::MatrixXd(m.rows(), 0);
  const Eigen::MatrixXd scaled = m * norms.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; }).asDiagonal();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
  qr.setThreshold(1e-9);
  return qr.householderQ() * Eigen::MatrixXd::Identity(m.rows(), qr.rank());
}

Eigen::MatrixXd masked(Eigen::MatrixXd z, const std::vector<bool>& used) {
  for (Eigen::Index i = 0; i < z.rows(); ++i)
    if (!used[static_cast<std::size_t>(i)]) z.row(i).setZero();
  return z;
}

}  // namespace

void Projection::set_readings(const Eigen::VectorXd& y) {
  residual_ = apply(y);
  square_ = y.dot(residual_);
}

FreePoseProjection::FreePoseProjection(const ProjectionInput& input) : used_(input.used) {
  const LinearProblem& problem = *input.problem;
  const auto n = static_cast<Eigen::Index>(problem.readings.size());
  rows_.resize(problem.poses.size());
  double count = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    // The points of a piece share no pose: free poses would explain each of them by itself.
    if (problem.poses[problem.readings[static_cast<std::size_t>(i)].pose].moving)
      used_[static_cast<std::size_t>(i)] = false;
    if (!used_[static_cast<std::size_t>(i)]) continue;
    ++count;
    const Reading& reading = problem.readings[static_cast<std::size_t>(i)];
    if (!problem.poses[reading.pose].reference) rows_[reading.pose].push_back(i);
  }
  double rank = 0;
  for (const std::vector<Eigen::Index>& rows : rows_) {
    Eigen::MatrixXd block(static_cast<Eigen::Index>(rows.size()), 6);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const Reading& reading = problem.readings[static_cast<std::size_t>(rows[k])];
      block.row(static_cast<Eigen::Index>(k)) = reading.functional.transpose() / reading.sigma;
    }
    q_.push_back(orthonormal(block));
    rank += static_cast<double>(q_.back().cols());
  }
  const auto unknowns = static_cast<Eigen::Index>(problem.unknowns.size());
  Eigen::MatrixXd border = Eigen::MatrixXd::Zero(n, unknowns + input.accepted.cols());
  for (Eigen::Index i = 0; i < n; ++i) {
    const Reading& reading = problem.readings[static_cast<std::size_t>(i)];
    for (const auto& [k, u] : problem.terms_of(reading)) border(i, k) += u / reading.sigma;
  }
  if (input.accepted.cols() > 0) border.rightCols(input.accepted.cols()) = input.accepted;
  border_ = Eigen::MatrixXd(n, 0);
  border_ = orthonormal(apply(border));
  rank += static_cast<double>(border_.cols());
  freedom_ = count - rank;
  set_readings(input.y);
}

Eigen::MatrixXd FreePoseProjection::apply(const Eigen::MatrixXd& z) const {
  Eigen::MatrixXd left = masked(z, used_);
  for (std::size_t p = 0; p < rows_.size(); ++p) {
    if (q_[p].cols() == 0) continue;
    const auto& rows = rows_[p];
    const Eigen::MatrixXd block = left(rows, Eigen::all);
    left(rows, Eigen::all) = block - q_[p] * (q_[p].transpose() * block);
  }
  if (border_.cols() > 0) left -= border_ * (border_.transpose() * left);
  return left;
}

SmoothProjection::SmoothProjection(const ProjectionInput& input, const HarmonicBasis& basis, const SmoothPrior& prior)
    : used_(input.used) {
  SmoothDesign design = smooth_design(*input.problem, basis, prior);
  const Eigen::Index base = design.columns.cols(), extra = input.accepted.cols();
  x_.resize(design.columns.rows(), base + extra);
  x_.leftCols(base) = design.columns;
  if (extra > 0) x_.rightCols(extra) = input.accepted;
  x_ = masked(std::move(x_), used_);
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(base + extra, base + extra);
  normal.selfadjointView<Eigen::Lower>().rankUpdate(x_.transpose());
  normal.triangularView<Eigen::StrictlyUpper>() = normal.transpose();
  normal.diagonal().head(base) += design.precision;
  const Eigen::VectorXd accepted_precision =
      input.precision.size() == extra ? input.precision : Eigen::VectorXd::Zero(extra);
  if (extra > 0) normal.diagonal().tail(extra) += accepted_precision;
  // Unknowns that no reading in use sees, and free columns alike in all readings, stay where they are.
  double free = 0;
  const double ridge = 1e-12 * normal.diagonal().maxCoeff();
  for (Eigen::Index k = 0; k < base + extra; ++k) {
    const bool is_free = (k >= base ? accepted_precision[k - base] : design.precision[k]) == 0;
    if (is_free) free += normal(k, k) > 0 ? 1 : 0;
    if (normal(k, k) <= 0) normal(k, k) = 1;
    if (is_free) normal(k, k) += std::min(ridge, 1e-9 * normal(k, k));
  }
  inverse_ = normal.llt().solve(Eigen::MatrixXd::Identity(base + extra, base + extra));
  // Location errors are free as well, by their wide prior: eight columns.
  double count = 0;
  for (const bool u : used_) count += u ? 1 : 0;
  freedom_ = count - free - 8;
  set_readings(input.y);
}

Eigen::MatrixXd SmoothProjection::apply(const Eigen::MatrixXd& z) const {
  const Eigen::MatrixXd left = masked(z, used_);
  return left - x_ * (inverse_ * (x_.transpose() * left));
}

}  // namespace trunnion
