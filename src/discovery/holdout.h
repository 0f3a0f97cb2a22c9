#pragma once

#include <vector>

#include "discovery/projection.h"

namespace trunnion {

/// Which readings serve for what; decided by position in the files alone, before anything is looked at.
struct Split {
  std::vector<bool> search;              ///< per reading
  std::vector<bool> holdout;             ///< per reading; all false without verification
  std::vector<std::vector<bool>> folds;  ///< without verification: the readings left out by each of them
  bool has_holdout() const;
  /// What is predicted from the rest: the hold-out, or fold after fold.
  std::vector<std::vector<bool>> parts() const;
};
/// Every other visit of the verification (rows from `verification_from` on) is kept back, the reference pose never;
/// without verification `folds` folds of poses. A visit is a run of readings at one pose.
Split split_by_poses(const LinearProblem& problem, std::size_t verification_from, int folds);

/// How well poses that took no part are predicted.
struct HoldoutError {
  double rms_um = 0;  ///< of the plain prediction errors
  /// Mean square of the innovations: errors whitened by their joint predictive covariance, pose by pose.
  double innovation = 0;
  std::vector<double> log_density;  ///< of each pose, given those before it
};
/// The error of predicting `parts` from all other readings in use.
HoldoutError holdout_error(const ProjectionInput& input, const SmoothDesign& design,
                           const std::vector<std::vector<bool>>& parts);

/// Whether the error falls: plain and whitened, and the predictive density rises by more than the standard error of its
/// rise over the poses.
bool falls(const HoldoutError& before, const HoldoutError& after);

}  // namespace trunnion
