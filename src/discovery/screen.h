#pragma once

#include <Eigen/Core>
#include <vector>

#include "discovery/candidate.h"

namespace trunnion {

/// All candidates side by side, judged together: a base has to be applied once, not once for each.
class Screen {
 public:
  Screen() = default;
  explicit Screen(std::vector<Candidate> candidates);

  const std::vector<Candidate>& candidates() const { return candidates_; }
  std::size_t column_count() const { return static_cast<std::size_t>(columns_.cols()); }

  /// How all of them fare against one base.
  struct View {
    const Projection* base = nullptr;
    Eigen::MatrixXd reduced;  ///< B' Z
    std::vector<VisibleSpace> spaces;
    std::vector<CandidateScore> scores;
  };
  View view(const Projection& base) const;
  /// The same; `map_columns` of the base are the map's. What their product with all candidates is, is remembered for as
  /// long as `version` of the map and the readings in use stay the same.
  View view(const SmoothProjection& base, Eigen::Index map_columns, int version);

  /// The largest canonical correlation, outside the base, between what `columns` can do and each candidate.
  std::vector<double> correlations(const View& view, const Eigen::MatrixXd& columns) const;

  /// The probability that the candidate of a view that does best by chance does as well as a gain of `gain` in `rank`
  /// columns: whole poses of what `chosen` leaves change their signs, so that heavy tails and poses that share a cause
  /// count as they come. Gains in different numbers of columns are compared by how far they exceed the chi-square
  /// quantile of `level` over all columns.
  double sign_flip_level(const LinearProblem& problem, const View& view, const Candidate& chosen, double gain,
                         double rank, double level, int flips = 999) const;

 private:
  Eigen::MatrixXd gram(std::size_t k, const Eigen::VectorXd& mask) const;
  View view_of(const Projection& base, Eigen::MatrixXd reduced) const;
  auto block(const Eigen::MatrixXd& all, std::size_t k) const {
    return all.middleCols(first_[k], first_[k + 1] - first_[k]);
  }

  std::vector<Candidate> candidates_;
  std::vector<Eigen::Index> first_;  ///< column of each, and one past the last
  Eigen::MatrixXd columns_;
  struct {
    int version = -1;
    Eigen::VectorXd mask;
    Eigen::MatrixXd xz;
  } products_;
};

}  // namespace trunnion
