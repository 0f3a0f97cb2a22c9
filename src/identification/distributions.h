#pragma once

namespace trunnion {

/// P(chi-square with `freedom` degrees > value).
double chi_square_tail(double value, double freedom);
/// P(F(freedom1, freedom2) > value).
double f_tail(double value, double freedom1, double freedom2);
/// P(X >= count) of a binomial with `trials` and `probability`.
double binomial_tail(double count, double trials, double probability);
/// The value that a chi-square with `freedom` degrees exceeds with probability `tail`.
double chi_square_quantile(double tail, double freedom);

}  // namespace trunnion
