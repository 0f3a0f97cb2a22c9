#pragma once

#include <span>

#include "history/error_series.h"

namespace trunnion {

/// One change of an error in time.
struct Change {
  bool drift = false;    ///< it goes on at a steady rate from `from` on; else a step between `from` and `to`
  std::size_t from = 0;  ///< index into ErrorSeries::points: the last calibration before
  std::size_t to = 0;    ///< step: the first calibration after; drift: the last calibration
  std::size_t earliest = 0, latest = 0;  ///< of `from`: with 95 % it lies within
  double p_value = 1;                    ///< that noise gives as much, over all changes that were tried
  Eigen::VectorXd amount;   ///< step: how far; drift: rate per year; inside units, at the places of the series
  Eigen::VectorXd std;      ///< standard uncertainty of each
  std::size_t largest = 0;  ///< where |amount| / std is largest
};

enum class Course {
  steady,    ///< the same in all calibrations, within their uncertainty
  changed,   ///< steps and drifts explain it
  scatters,  ///< it varies more than its uncertainty says, and no step nor drift explains how
};

/// What an error did over the calibrations.
struct SeriesFinding {
  Course course = Course::steady;
  double p_value = 1;           ///< that one constant explains all calibrations (chi-square)
  std::vector<Change> changes;  ///< in the order of time
  double left_p_value = 1;      ///< the same after the changes
  double scatter = 1;           ///< what is left over what the uncertainties say, in standard deviations; >= 1
};

/// Tells changes from noise. `years` are the times of the models that the series' points refer to.
///
/// The points y_k of covariance V_k are followed by y_k = mu + sum beta_i g_i(t_k) + noise, with g a step at some
/// calibration or a rate that begins at some calibration, all beta as long as y; weighted least squares, every V_k on
/// what the mean covariance spans. Changes are added one by one, the one that explains most of chi-square first, for as
/// long as what is left fails (p < 0.01) and the gain passes at `level` over all that were tried (Bonferroni), at most
/// half as many as there are calibrations. Where what is left still fails, the gain is judged against that scatter
/// (F test), and the uncertainties are enlarged by it.
SeriesFinding find_changes(const ErrorSeries& series, std::span<const double> years, double level);

/// Standard deviations by which errors wander off in one year, were their changes a random walk: maximum likelihood
/// over the given series, each of single numbers, that share a rate; and the largest rate that they do not contradict
/// at 10 % (one-sided likelihood ratio). Both in inside units per square root of a year. Series with fewer than two
/// points say nothing; 0 and infinity where none says anything.
struct WanderingRate {
  double likely = 0;
  double at_most = 0;
};
WanderingRate wandering_rate(std::span<const ErrorSeries> series, std::span<const double> years);

}  // namespace trunnion
