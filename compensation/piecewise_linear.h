#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace trunnion {

/// What lies beyond the nodes of a table: the end value is held, or the table repeats (its last node is its first).
enum class Boundary { hold, repeat };

/// Piecewise linear functions on given nodes, and the nearest of them to a sampled function.
///
///   f(x) = sum_i h_i(x) v_i,   h_i the hat function of node i;   v = argmin sum_s (f(x_s) - y_s)^2 = P y.
///
/// A table of a control that is linear between its nodes is such a function; least squares over the whole range loses
/// half of what values taken at the nodes lose, because a curve stands on one side of its chords.
class PiecewiseLinear {
 public:
  /// `nodes` ascend strictly, two or more; with Boundary::repeat the last stands for the first.
  PiecewiseLinear(std::vector<double> nodes, Boundary boundary);

  const std::vector<double>& nodes() const { return nodes_; }
  /// The points at which a function is to be sampled: the nodes and `between` points in every gap.
  std::vector<double> sample_points(int between) const;
  /// P for samples at `points`: nodes x points; with Boundary::repeat first and last row agree. With `zero_at` the
  /// nearest among those functions that are zero there.
  Eigen::MatrixXd projector(const std::vector<double>& points, std::optional<double> zero_at = {}) const;

  /// The weights h_i(x): f(x) = h . v.
  Eigen::VectorXd weights(double x) const;
  /// How the nearest function gives way where it must be higher by one at `x`, with N = H^T H over the points:
  ///   y = N^-1 h(x) / (h(x)^T N^-1 h(x)),
  /// what is added to v to meet f(x) = f0 being (f0 - h . v) y. Over two axes it is the product of both.
  Eigen::VectorXd yielding(const std::vector<double>& points, double x) const;

 private:
  Eigen::Index unknowns() const;
  Eigen::MatrixXd hats(const std::vector<double>& points) const;
  Eigen::MatrixXd closed(const Eigen::MatrixXd& of_unknowns) const;

  std::vector<double> nodes_;
  Boundary boundary_;
};

/// `low`, `low` + step, … `high`, the step shortened to fit a whole number of times.
std::vector<double> even_nodes(double low, double high, double step);

}  // namespace trunnion
