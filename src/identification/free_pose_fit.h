#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "identification/linear_problem.h"

namespace trunnion {

/// A freedom of one pose that no reading sees.
struct UnseenFreedom {
  std::uint32_t pose = 0;                 ///< index into LinearProblem::poses
  Vector6d direction = Vector6d::Zero();  ///< unit vector over (D / mm, theta * 100 mm)
  std::vector<std::size_t> components;    ///< of Delta that take part in it, 0..5
};

/// Every pose error by itself, jointly with the measurement's unknowns.
struct FreePoseFit {
  std::vector<PoseError> delta;        ///< one per pose of the problem; zero at the reference pose
  std::vector<std::ptrdiff_t> column;  ///< first column of each pose in `covariance`; -1 for the reference pose
  Eigen::MatrixXd covariance;  ///< of the stacked deltas, mm and rad, for the declared sigma; unseen freedoms left out
  Eigen::VectorXd unknowns;    ///< the measurement's unknowns, mm or rad
  std::vector<double> residual;    ///< observed minus fitted, one per reading (mm or rad); also of removed ones
  std::vector<double> redundancy;  ///< r_i = 1 - h_ii, 0 for a reading that nothing checks
  double weighted_rss = 0;         ///< sum of (residual / sigma)^2 over the readings used
  std::size_t readings = 0;        ///< used
  std::size_t unknown_count = 0;   ///< pose freedoms and measurement's unknowns asked for
  std::size_t rank = 0;
  double condition = 0;  ///< largest over the poses, angles scaled by 0.1 m
  std::vector<UnseenFreedom> unseen;
  std::vector<std::string> undetermined_unknowns;  ///< of the measurement

  std::size_t degrees_of_freedom() const { return readings - rank; }
};

/// Joint weighted least squares over all poses and unknowns, by bordered block elimination: each pose's 6 x 6 block
/// first, then the Schur complement of the unknowns. `used[i]` tells whether reading i takes part (empty: all do).
/// Exact to second order: the solution is iterated on nonlinear_excess_mm. The shared noise of the reference readings
/// is in the covariance as it is. Throws ModelError for a problem with pose readings, whose mounts leave free poses
/// undetermined, or with the points of a piece, which share no pose.
FreePoseFit fit_free_poses(const LinearProblem& problem, const std::vector<bool>& used = {});

/// The paper's two steps: each pose by itself from differences to the reference readings (Eq. 6-9); the covariance is
/// the true one, reference noise shared between poses included. Throws InputError for a spot without a reference
/// reading.
FreePoseFit fit_two_step(const LinearProblem& problem);

}  // namespace trunnion
