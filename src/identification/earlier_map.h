#pragma once

#include "identification/smooth_fit.h"
#include "model/effects/rotary_error_map.h"

namespace trunnion {

/// How far a machine may have moved since a map of it was made: the standard deviation of the constant part of each
/// error (of a location error); the parts that vary with the angles fall off as those of a SmoothPrior do, from the
/// same number on.
struct Drift {
  Length length;
  Angle angle;
};

/// A belief, and the basis that it speaks of.
struct CarriedMap {
  HarmonicBasis basis;
  CoefficientBelief belief;
  double misfit = 1;  ///< reduced chi-square of the earlier map's nodes against the basis, where it had to be fitted
};

/// What an earlier map lets one believe of the machine now, if it has moved by a random `drift` since:
///   beta ~ N(T beta_0, T C_0 T^T + Q),   Q = diag(variances of the drift),
/// T rewriting the earlier coefficients beta_0 (posterior covariance C_0) in a basis that holds theirs and `wanted`;
/// functions that the earlier basis lacks keep the variance of `prior`. A map without a smooth surface is first carried
/// over to one by generalised least squares on its nodes, its uncertainty enlarged by what they miss it by. Throws
/// ModelError for a map without standard uncertainties.
CarriedMap carried_over(const RotaryErrorMap& earlier, const LinearProblem& problem, const HarmonicBasis& wanted,
                        const SmoothPrior& prior, Drift drift);

}  // namespace trunnion
