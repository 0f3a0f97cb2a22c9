#pragma once

#include <vector>

#include "discovery/projection.h"

namespace trunnion {

/// Which readings serve for what; decided by position in the files alone, before anything is looked at.
struct Split {
  std::vector<bool> search;              ///< per reading
  std::vector<bool> holdout;             ///< per reading; all false without verification
  std::vector<std::vector<bool>> folds;  ///< of the poses that are searched: the readings left out by each of them
  bool has_holdout() const;
};
/// Every other visit of the verification (rows from `verification_from` on) is kept back, the reference pose never. A
/// visit is a run of readings at one pose. The poses that are searched fall into `folds` folds. In the log of an axis
/// that goes on moving, where positions have fewer readings than freedoms, blocks take the place of poses: an eighth of
/// the run by 15 deg of the tilt by 30 deg of C.
Split split_by_poses(const LinearProblem& problem, std::size_t verification_from, int folds);

/// How well poses that took no part are predicted.
struct HoldoutError {
  /// Of the innovations: errors whitened by their joint predictive covariance, given those before, times sigma. A model
  /// that lacks nothing has sigma here, however far from the other poses one that was kept back is.
  double rms_um = 0;
  double plain_rms_um = 0;  ///< of the errors as they are; poses that are hard to predict govern it
  /// Of each part: the whitened errors, and their joint predictive covariance.
  struct Part {
    Eigen::VectorXd error;
    Eigen::MatrixXd covariance;
  };
  std::vector<Part> parts;
};
/// The error of predicting `parts` from all other readings in use.
HoldoutError holdout_error(const ProjectionInput& input, const SmoothDesign& design,
                           const std::vector<std::vector<bool>>& parts);

/// How the error of prediction falls from one model to another.
struct Fall {
  double rms_um = 0;          ///< before less after
  double gain = 0;            ///< log p(after) - log p(before)
  double standard_error = 0;  ///< of the gain, where `before` is right
  double shift = 0;           ///< by how many standard deviations, in all, the two models predict otherwise

  /// By more than its standard error.
  bool clear() const { return rms_um > 0 && gain > standard_error; }
  /// What was kept back hardly feels the difference: nine times in ten a true effect would be clear, were it felt.
  bool silent() const { return shift < 4.5; }
  bool contradicts() const { return gain < -standard_error; }
};
Fall fall(const HoldoutError& before, const HoldoutError& after);

}  // namespace trunnion
