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
  /// P for samples at `points`: nodes x points; with Boundary::repeat first and last row agree.
  /// Where the control counts from one of the nodes, that one is `pinned` to zero and the others do what they can.
  Eigen::MatrixXd projector(const std::vector<double>& points, std::optional<std::size_t> pinned = {}) const;

 private:
  std::vector<double> nodes_;
  Boundary boundary_;
};

/// `low`, `low` + step, … `high`, the step shortened to fit a whole number of times.
std::vector<double> even_nodes(double low, double high, double step);

}  // namespace trunnion
