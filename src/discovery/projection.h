#pragma once

#include <Eigen/Core>
#include <vector>

#include "identification/smooth_fit.h"

namespace trunnion {

/// The readings of a fit as whitened vectors (divided by their sigma), and what a base model leaves of any other
/// vector. y' P y is chi-square with `freedom` degrees if nothing is missing; a candidate's columns Z are judged by Z'
/// P Z and Z' P y.
class Projection {
 public:
  virtual ~Projection() = default;
  /// P Z for whitened columns, rows as the readings.
  virtual Eigen::MatrixXd apply(const Eigen::MatrixXd& z) const = 0;
  const Eigen::VectorXd& residual() const { return residual_; }  ///< P y
  double residual_square() const { return square_; }             ///< y' P y
  double freedom() const { return freedom_; }

 protected:
  void set_readings(const Eigen::VectorXd& y);
  Eigen::VectorXd residual_;
  double square_ = 0;
  double freedom_ = 0;
};

/// What both bases start from: which readings take part (0: not), and columns of effects that are already in the model.
struct ProjectionInput {
  const LinearProblem* problem = nullptr;
  std::vector<bool> used;     ///< one per reading; those out of use count as zero rows
  Eigen::VectorXd y;          ///< whitened values, one per reading
  Eigen::MatrixXd accepted;   ///< whitened columns, one row per reading
  Eigen::VectorXd precision;  ///< prior precision of the accepted columns; empty: free
};

/// Free pose errors at every indexed position and the measurement's unknowns: P is the orthogonal projection off them.
/// It sees only what is not rigid within a pose, but believes nothing about the maps.
class FreePoseProjection : public Projection {
 public:
  explicit FreePoseProjection(const ProjectionInput& input);
  Eigen::MatrixXd apply(const Eigen::MatrixXd& z) const override;

 private:
  std::vector<std::vector<Eigen::Index>> rows_;  ///< per pose
  std::vector<Eigen::MatrixXd> q_;               ///< per pose, orthonormal
  std::vector<bool> used_;
  Eigen::MatrixXd border_;  ///< orthonormal, off the poses
};

/// A smooth map with a Gaussian-process prior: P = I - X (X' X + prior^-1)^-1 X'. It sees rigid effects too, as far as
/// they break the smoothness of the map.
class SmoothProjection : public Projection {
 public:
  SmoothProjection(const ProjectionInput& input, const HarmonicBasis& basis, const SmoothPrior& prior);
  Eigen::MatrixXd apply(const Eigen::MatrixXd& z) const override;

 private:
  Eigen::MatrixXd x_;
  Eigen::MatrixXd inverse_;
  std::vector<bool> used_;
};

}  // namespace trunnion
