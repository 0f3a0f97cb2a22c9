#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "errormap/harmonic_surface.h"
#include "identification/linear_problem.h"

namespace trunnion {

/// The prior of a smooth map: a Gaussian process over (a, c), periodic in c, told by the standard deviations of its
/// coefficients in a HarmonicBasis. Degree k of the tilt falls as exp(-tilt_decay k); C's functions of the tilt as
/// exp(-turn_decay k); the amplitude of harmonic h is that of h - 1 times harmonic_ratio[h - 2] < 1. Constants of both
/// axes (location errors) are left free.
struct SmoothPrior {
  double tilt_um = 3, tilt_urad = 10, tilt_decay = 0.8;
  double turn_um = 2, turn_urad = 8, turn_decay = 0.8;
  std::vector<double> harmonic_ratio;
  double length_noise = 1, angle_noise = 1;  ///< sigma found over sigma declared, where it was left to the data
};

/// What is believed of a map's coefficients before the readings: a normal distribution.
struct CoefficientBelief {
  Eigen::VectorXd mean;        ///< of a HarmonicSurface, mm and rad
  Eigen::MatrixXd covariance;  ///< positive definite
};

/// What a smooth fit takes for granted, and what it fits beside the map.
struct SmoothOptions {
  std::optional<SmoothPrior> prior;  ///< used as it is; else found by restricted maximum likelihood (REML)
  std::optional<SmoothPrior> start;  ///< where the search for the prior begins, if not at its centre
  std::optional<CoefficientBelief>
      belief;                     ///< takes the place of the prior's zero mean and variances; asks for `prior`
  bool free_noise = false;        ///< the noise level is found too
  std::vector<double> weights;    ///< one per reading on 1/sigma^2, 0 leaves it out; empty: all 1
  std::vector<double> values;     ///< replaces Reading::value (relinearised readings); empty: as they are
  Eigen::MatrixXd extra_columns;  ///< further unknowns without prior: one row per reading (mm or rad), one column each
  Eigen::VectorXd extra_precision;            ///< prior precision of each extra unknown; empty: they are free
  std::function<void(double)> progress = {};  ///< is told what share of the fit is done, 0 … 1
};

/// A map as one smooth function through all readings, with the measurement's unknowns.
struct SmoothFit {
  HarmonicBasis basis;
  SmoothPrior prior;
  Eigen::VectorXd coefficients;  ///< of a HarmonicSurface, mm and rad
  Eigen::MatrixXd covariance;    ///< posterior, of the coefficients
  Eigen::VectorXd unknowns;      ///< the measurement's
  Eigen::VectorXd extra;         ///< of extra_columns
  Eigen::MatrixXd extra_covariance;
  std::vector<double> residual;    ///< observed minus fitted, per reading, mm or rad
  std::vector<double> redundancy;  ///< 1 - h_ii of each reading used; 0 for those left out
  double weighted_rss = 0;
  double belief_misfit = 0;         ///< (beta - mean)^T covariance^-1 (beta - mean) of a belief
  double log_evidence = 0;          ///< restricted log likelihood, up to a constant of the data
  double effective_parameters = 0;  ///< trace of the influence, unknowns included
  std::size_t readings = 0;
};

/// The basis that a set of poses can carry: harmonics up to what the C positions resolve (at most `most_harmonics`),
/// the tilt's degree and C's functions of the tilt by how many tilts there are.
HarmonicBasis basis_for(const LinearProblem& problem, int most_harmonics = 6);

/// The posterior of the basis' coefficients and the measurement's unknowns, given the readings in use.
SmoothFit fit_smooth(const LinearProblem& problem, const HarmonicBasis& basis, const SmoothOptions& options = {});

/// The fit without the directions of its coefficients that no pose error shows (constants that one axis can take over
/// from the other): they are as uncertain as their prior is wide, and their variance, a hundred million times that of
/// the others, would drown those in a file's last digit. No pose error and none of its variances is changed.
SmoothFit without_unseen_constants(SmoothFit fit, const KinematicChain& chain);

/// Prior variances of the coefficients of `basis`, mm^2 and rad^2.
Eigen::VectorXd prior_variances(const LinearProblem& problem, const HarmonicBasis& basis, const SmoothPrior& prior);

/// Whitened design of a smooth fit, one row per reading: the basis' coefficients, then the measurement's unknowns, in
/// units in which the numbers are of order one (um, urad); and the prior precision of each column (0: free).
struct SmoothDesign {
  Eigen::MatrixXd columns;
  Eigen::VectorXd precision;
};
SmoothDesign smooth_design(const LinearProblem& problem, const HarmonicBasis& basis, const SmoothPrior& prior);
/// The precision alone: the columns do not depend on the prior.
Eigen::VectorXd smooth_precision(const LinearProblem& problem, const HarmonicBasis& basis, const SmoothPrior& prior);

/// The 6 x m derivative of the pose error at `situation` by the coefficients of a HarmonicSurface, gauged at the
/// reference pose.
Matrix6Xd gauged_basis(const KinematicChain& chain, const HarmonicBasis& basis, const Situation& situation);

}  // namespace trunnion
