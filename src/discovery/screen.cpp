#include "discovery/screen.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "identification/distributions.h"
#include "linear_algebra/factors.h"

namespace trunnion {

Screen::Screen(std::vector<Candidate> candidates) : candidates_(std::move(candidates)) {
  first_.push_back(0);
  for (const Candidate& c : candidates_) first_.push_back(first_.back() + c.columns.cols());
  if (!candidates_.empty()) columns_ = side_by_side(candidates_, candidates_.front().columns.rows()).columns;
}

Eigen::MatrixXd Screen::gram(std::size_t k, const Eigen::VectorXd& mask) const {
  const auto z = block(columns_, k);
  return z.transpose() * mask.asDiagonal() * z;
}

Screen::View Screen::view(const Projection& base) const { return view_of(base, base.reduced(columns_)); }

Screen::View Screen::view(const SmoothProjection& base, Eigen::Index map_columns, int version) {
  if (products_.version != version || products_.mask != base.mask()) {
    products_.version = version;
    products_.mask = base.mask();
    products_.xz = base.columns().leftCols(map_columns).transpose() * (base.mask().asDiagonal() * columns_);
  }
  const Eigen::Index effects = base.columns().cols() - map_columns;
  Eigen::MatrixXd xz(base.columns().cols(), columns_.cols());
  xz.topRows(map_columns) = products_.xz;
  if (effects > 0)
    xz.bottomRows(effects) = (base.mask().asDiagonal() * base.columns().rightCols(effects)).transpose() * columns_;
  return view_of(base, base.reduced_products(std::move(xz)));
}

Screen::View Screen::view_of(const Projection& base, Eigen::MatrixXd reduced_columns) const {
  View view{.base = &base, .reduced = std::move(reduced_columns)};
  const Eigen::VectorXd products = columns_.transpose() * base.residual();
  for (std::size_t k = 0; k < candidates_.size(); ++k) {
    const Eigen::MatrixXd gram_z = gram(k, base.mask());
    const auto reduced = block(view.reduced, k);
    view.spaces.push_back(visible_space(gram_z, gram_z - reduced.transpose() * reduced));
    view.scores.push_back(score_in(view.spaces.back(), products.segment(first_[k], first_[k + 1] - first_[k]), base));
  }
  return view;
}

std::vector<double> Screen::correlations(const View& view, const Eigen::MatrixXd& columns) const {
  const Eigen::MatrixXd projected = view.base->apply(columns);
  const Eigen::MatrixXd used = view.base->mask().asDiagonal() * columns;
  const VisibleSpace own = visible_space(used.transpose() * used, columns.transpose() * projected);
  const Eigen::MatrixXd cross = (projected * own.whitening).transpose() * columns_;
  std::vector<double> found;
  for (std::size_t k = 0; k < candidates_.size(); ++k) {
    const Eigen::MatrixXd c = block(cross, k) * view.spaces[k].whitening;
    double largest = 0;
    if (c.size() > 0)
      largest = c.rows() <= c.cols() ? SymmetricEigen(c * c.transpose()).eigenvalues().maxCoeff()
                                     : SymmetricEigen(c.transpose() * c).eigenvalues().maxCoeff();
    found.push_back(std::sqrt(std::clamp(largest, 0.0, 1.0)));
  }
  return found;
}

double Screen::sign_flip_level(const LinearProblem& problem, const View& view, const Candidate& chosen, double gain,
                               double rank, double level, int flips) const {
  const double share = level / static_cast<double>(std::max<std::size_t>(1, column_count()));
  std::map<double, double> threshold;
  const auto excess = [&](double g, double m) {
    const auto [at, added] = threshold.try_emplace(m, 0);
    if (added) at->second = chi_square_quantile(share, m);
    return g - at->second;
  };
  const double observed = excess(gain, rank);

  // What the chosen candidate leaves is the noise to turn.
  const Projection& base = *view.base;
  const Eigen::MatrixXd projected = base.apply(chosen.columns);
  const Eigen::MatrixXd used = base.mask().asDiagonal() * chosen.columns;
  const VisibleSpace own = visible_space(used.transpose() * used, chosen.columns.transpose() * projected);
  const Eigen::MatrixXd direction = projected * own.whitening;
  const Eigen::VectorXd left =
      base.residual() - direction * (own.whitening.transpose() * (chosen.columns.transpose() * base.residual()));

  // Sum over each pose of what its readings contribute to W' Z' P left, for all candidates.
  const auto poses = static_cast<Eigen::Index>(problem.poses.size());
  const auto pose_of = [&](Eigen::Index i) {
    return static_cast<Eigen::Index>(problem.readings[static_cast<std::size_t>(i)].pose);
  };
  Eigen::MatrixXd by_pose = Eigen::MatrixXd::Zero(poses, columns_.cols());
  for (Eigen::Index k = 0; k < columns_.cols(); ++k)
    for (Eigen::Index i = 0; i < left.size(); ++i) by_pose(pose_of(i), k) += left[i] * columns_(i, k);
  // left' P Z by pose = left' Z - (B' left)' (B' Z), each pose's part of `left` by itself.
  Eigen::MatrixXd of_pose = Eigen::MatrixXd::Zero(left.size(), poses);
  for (Eigen::Index i = 0; i < left.size(); ++i) of_pose(i, pose_of(i)) = left[i];
  by_pose.noalias() -= base.reduced(of_pose).transpose() * view.reduced;
  std::vector<Eigen::MatrixXd> whitened;
  for (std::size_t k = 0; k < candidates_.size(); ++k)
    if (view.scores[k].rank > 0) whitened.push_back(block(by_pose, k) * view.spaces[k].whitening);

  std::mt19937_64 random(20081);
  Eigen::MatrixXd signs(flips, poses);
  for (Eigen::Index f = 0; f < flips; ++f)
    for (Eigen::Index p = 0; p < poses; ++p) signs(f, p) = random() >> 63 ? 1 : -1;
  Eigen::VectorXd best = Eigen::VectorXd::Constant(flips, -std::numeric_limits<double>::infinity());
  for (const Eigen::MatrixXd& w : whitened) {
    const Eigen::VectorXd gains = (signs * w).rowwise().squaredNorm();
    best = best.cwiseMax((gains.array() + excess(0, static_cast<double>(w.cols()))).matrix());
  }
  const auto reached = (best.array() >= observed).count();
  return (static_cast<double>(reached) + 1) / (flips + 1.0);
}

}  // namespace trunnion
