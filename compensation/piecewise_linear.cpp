#include "compensation/piecewise_linear.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "linear_algebra/factors.h"

namespace trunnion {

PiecewiseLinear::PiecewiseLinear(std::vector<double> nodes, Boundary boundary)
    : nodes_(std::move(nodes)), boundary_(boundary) {
  assert(nodes_.size() >= 2 && std::ranges::adjacent_find(nodes_, std::greater_equal<>()) == nodes_.end());
}

std::vector<double> PiecewiseLinear::sample_points(int between) const {
  std::vector<double> points;
  for (std::size_t i = 0; i + 1 < nodes_.size(); ++i)
    for (int k = 0; k <= between; ++k) points.push_back(nodes_[i] + (nodes_[i + 1] - nodes_[i]) * k / (between + 1));
  points.push_back(nodes_.back());
  return points;
}

Eigen::MatrixXd PiecewiseLinear::projector(const std::vector<double>& points, std::optional<std::size_t> pinned) const {
  const auto n = static_cast<Eigen::Index>(nodes_.size());
  const auto m = static_cast<Eigen::Index>(points.size());
  const Eigen::Index unknowns = boundary_ == Boundary::repeat ? n - 1 : n;
  Eigen::MatrixXd hats = Eigen::MatrixXd::Zero(m, unknowns);
  for (Eigen::Index s = 0; s < m; ++s) {
    const double x = points[static_cast<std::size_t>(s)];
    const auto above = std::upper_bound(nodes_.begin() + 1, nodes_.end() - 1, x);
    const auto i = above - nodes_.begin() - 1;
    const double u = (x - nodes_[static_cast<std::size_t>(i)]) / (*above - nodes_[static_cast<std::size_t>(i)]);
    hats(s, i) += 1 - u;
    hats(s, (i + 1) % unknowns) += u;
  }
  if (pinned) hats.col(static_cast<Eigen::Index>(*pinned) % unknowns).setZero();
  Eigen::MatrixXd normal = hats.transpose() * hats;
  if (pinned) normal(static_cast<Eigen::Index>(*pinned) % unknowns, static_cast<Eigen::Index>(*pinned) % unknowns) = 1;
  Eigen::MatrixXd projected(n, m);
  projected.topRows(unknowns) = Cholesky(normal).solve(hats.transpose());
  if (unknowns < n) projected.row(n - 1) = projected.row(0);
  return projected;
}

std::vector<double> even_nodes(double low, double high, double step) {
  const auto cells = std::max(1.0, std::ceil((high - low) / step - 1e-9));
  std::vector<double> nodes;
  for (double k = 0; k <= cells; ++k) nodes.push_back(low + (high - low) * k / cells);
  return nodes;
}

}  // namespace trunnion
