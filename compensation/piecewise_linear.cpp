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

Eigen::Index PiecewiseLinear::unknowns() const {
  const auto n = static_cast<Eigen::Index>(nodes_.size());
  return boundary_ == Boundary::repeat ? n - 1 : n;
}

Eigen::MatrixXd PiecewiseLinear::hats(const std::vector<double>& points) const {
  Eigen::MatrixXd hats = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(points.size()), unknowns());
  for (Eigen::Index s = 0; s < hats.rows(); ++s) {
    const double x = points[static_cast<std::size_t>(s)];
    const auto above = std::upper_bound(nodes_.begin() + 1, nodes_.end() - 1, x);
    const auto i = above - nodes_.begin() - 1;
    const double u = (x - nodes_[static_cast<std::size_t>(i)]) / (*above - nodes_[static_cast<std::size_t>(i)]);
    hats(s, i) += 1 - u;
    hats(s, (i + 1) % unknowns()) += u;
  }
  return hats;
}

/// Rows of the unknowns to rows of the nodes.
Eigen::MatrixXd PiecewiseLinear::closed(const Eigen::MatrixXd& of_unknowns) const {
  Eigen::MatrixXd of_nodes(static_cast<Eigen::Index>(nodes_.size()), of_unknowns.cols());
  of_nodes.topRows(unknowns()) = of_unknowns;
  if (boundary_ == Boundary::repeat) of_nodes.bottomRows(1) = of_unknowns.topRows(1);
  return of_nodes;
}

Eigen::VectorXd PiecewiseLinear::weights(double x) const {
  Eigen::VectorXd of_nodes = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(nodes_.size()));
  of_nodes.head(unknowns()) = hats({x}).transpose();
  return of_nodes;
}

Eigen::MatrixXd PiecewiseLinear::projector(const std::vector<double>& points, std::optional<double> zero_at) const {
  const Eigen::MatrixXd h = hats(points);
  const Eigen::MatrixXd projected = closed(Cholesky(h.transpose() * h).solve(h.transpose()));
  if (!zero_at) return projected;
  return projected - yielding(points, *zero_at) * (weights(*zero_at).transpose() * projected);
}

Eigen::VectorXd PiecewiseLinear::yielding(const std::vector<double>& points, double x) const {
  const Eigen::MatrixXd h = hats(points);
  const Eigen::MatrixXd at_x = hats({x});
  const Eigen::MatrixXd gives = Cholesky(h.transpose() * h).solve(at_x.transpose());
  return closed(gives / (at_x * gives)(0, 0));
}

std::vector<double> even_nodes(double low, double high, double step) {
  const auto cells = std::max(1.0, std::ceil((high - low) / step - 1e-9));
  std::vector<double> nodes;
  for (double k = 0; k <= cells; ++k) nodes.push_back(low + (high - low) * k / cells);
  return nodes;
}

}  // namespace trunnion
