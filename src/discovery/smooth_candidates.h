#pragma once

#include <optional>
#include <string>
#include <vector>

#include "discovery/candidate.h"

namespace trunnion {

/// A smooth effect of one or two covariates that the catalogue does not name.
struct SmoothCandidate {
  Candidate candidate;
  double p_value = 1;         ///< family-wise over all terms tried, by the exponential tail of the largest gain
  double log_likelihood = 0;  ///< REML gain over no such effect, less the price of its hyperparameters
};

/// The smooth effect with the highest likelihood among one or two covariates of all columns that the readings carry and
/// what can be derived from them, along the machine's axes, the table's axes or the approach; empty if none beats the
/// threshold that projected noise reaches with probability `level`. A column that was seen to act on the measurement
/// (`on_measurement`) is tried for what more it does to the measurement, not for what it might do to the machine.
std::optional<SmoothCandidate> best_smooth_candidate(const LinearProblem& problem, const Projection& base,
                                                     const CandidateScope& scope,
                                                     const std::vector<std::string>& on_measurement, double level);

}  // namespace trunnion
