#pragma once

#include <span>

#include "history/error_series.h"

namespace trunnion {

/// One change of an error in time.
struct Change {
  std::string error;
  Unit unit = Unit::um;
  std::vector<IndexedPosition> places;
  bool drift = false;        ///< it goes on at a steady rate from `from` on; else a step between `from` and `to`
  std::size_t from = 0;      ///< index into the points: the last calibration before
  std::size_t to = 0;        ///< step: the first calibration after; drift: the last calibration
  std::size_t earliest = 0;  ///< of `from`: with 95 % it lies between these two, if it is a change of this kind
  std::size_t latest = 0;
  double p_value = 1;       ///< that noise gives as much, over everything that was tried
  Eigen::VectorXd amount;   ///< step: how far; drift: rate per year; inside units, at the places
  Eigen::VectorXd std;      ///< standard uncertainty of each
  std::size_t largest = 0;  ///< where |amount| / std is largest
};

/// What a set of errors did over the calibrations.
struct CourseFinding {
  double p_value = 1;           ///< that all calibrations saw the same (chi-square)
  std::vector<Change> changes;  ///< in the order of time
  double left_p_value = 1;      ///< the same after the changes
  double scatter = 1;           ///< what is left, over what the uncertainties say, in standard deviations; >= 1
};

/// Tells changes from noise. `years` are the times of the models that the points refer to.
///
/// The points y_k of covariance V_k are followed by y_k = mu + sum X_i beta_i g_i(t_k) + noise, with X_i one of the
/// modes and g_i a step at some calibration or a rate that begins at some calibration; weighted least squares, every
/// V_k on what the mean covariance spans. Changes are added one by one: of all modes and times the one that noise would
/// mimic least (chi-square of the gain, with as many degrees of freedom as the mode has visible coefficients), for as
/// long as that p, times all that were tried, is below `level`; the times of the earlier ones are found anew each time.
/// A single location error so wins over a function that could do the same, and a function over the location error that
/// resembles it. Where what is left fails (p < 0.01), gains are judged against that scatter (F), and uncertainties are
/// enlarged by it.
CourseFinding find_changes(const ChangeProblem& problem, std::span<const double> years, double level);

/// The problem of one series of single numbers.
ChangeProblem single_problem(const ErrorSeries& series);

/// What differs between the two points of a series, where the difference is most of its standard uncertainty.
struct Difference {
  std::size_t largest = 0;                                      ///< index into the places
  double before = 0, before_std = 0, after = 0, after_std = 0;  ///< there, inside units
  double p_value = 1;  ///< that noise gives as much over all places (chi-square)
};
Difference difference(const ErrorSeries& series);

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
