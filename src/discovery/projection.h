#pragma once

#include <Eigen/Core>
#include <vector>

#include "identification/smooth_fit.h"

namespace trunnion {

/// The readings of a fit as whitened vectors (divided by their sigma), and what a base model leaves of any other
/// vector: P = M - B B', M the readings in use. y' P y is chi-square with `freedom` degrees if nothing is missing; a
/// candidate's columns Z are judged by Z' P Z and Z' P y, for which B' Z is enough.
class Projection {
 public:
  virtual ~Projection() = default;
  /// B' Z of whitened columns, rows as the readings; those out of use count as zero.
  virtual Eigen::MatrixXd reduced(const Eigen::MatrixXd& z) const = 0;
  /// P Z.
  Eigen::MatrixXd apply(const Eigen::MatrixXd& z) const;
  const Eigen::VectorXd& residual() const { return residual_; }  ///< P y
  double residual_square() const { return square_; }             ///< y' P y
  double freedom() const { return freedom_; }
  const Eigen::VectorXd& mask() const { return mask_; }  ///< 1 for each reading in use, else 0

 protected:
  explicit Projection(const std::vector<bool>& used);
  /// B R.
  virtual Eigen::MatrixXd expanded(const Eigen::MatrixXd& r) const = 0;
  void set_readings(const Eigen::VectorXd& y);

  Eigen::VectorXd mask_, residual_;
  double square_ = 0, freedom_ = 0;
};

/// Columns of effects in a fit, whitened, one row per reading, with the prior precision of each (0: free).
struct EffectColumns {
  Eigen::MatrixXd columns;
  Eigen::VectorXd precision;
};

/// What both bases start from: which readings take part, and the effects that are already in the model.
struct ProjectionInput {
  const LinearProblem* problem = nullptr;
  std::vector<bool> used;  ///< one per reading
  Eigen::VectorXd y;       ///< whitened values, one per reading
  EffectColumns accepted;
};

/// Free pose errors at every indexed position and the measurement's unknowns: P is the orthogonal projection off them.
/// It sees only what is not rigid within a pose, but believes nothing about the maps.
class FreePoseProjection : public Projection {
 public:
  explicit FreePoseProjection(const ProjectionInput& input);
  Eigen::MatrixXd reduced(const Eigen::MatrixXd& z) const override;

 private:
  Eigen::MatrixXd expanded(const Eigen::MatrixXd& r) const override;

  std::vector<std::vector<Eigen::Index>> rows_;  ///< per pose
  std::vector<Eigen::MatrixXd> q_;               ///< per pose, orthonormal
  Eigen::Index pose_rank_ = 0;
  Eigen::MatrixXd border_;  ///< orthonormal, off the poses
};

/// A smooth map with a Gaussian-process prior, and effects with theirs: P = (I + X prior X')^-1. It sees rigid effects
/// too, as far as they break the smoothness of the map.
class SmoothProjection : public Projection {
 public:
  SmoothProjection(const ProjectionInput& input, const SmoothDesign& design);
  Eigen::MatrixXd reduced(const Eigen::MatrixXd& z) const override;
  /// The same from X' M Z, the map's columns first: with the same map and readings, only the prior changes it.
  Eigen::MatrixXd reduced_products(Eigen::MatrixXd xz) const;
  const Eigen::MatrixXd& columns() const { return x_; }  ///< X, all readings

  /// What the fit leaves of readings out of use, X_h mean taken off y_h, and F with covariance I + F F' of that.
  struct Prediction {
    Eigen::VectorXd error;
    Eigen::MatrixXd factor;
  };
  Prediction predict(const std::vector<Eigen::Index>& rows) const;
  /// y - X mean of every reading, whitened.
  Eigen::VectorXd misfit() const;

 private:
  Eigen::MatrixXd expanded(const Eigen::MatrixXd& r) const override;

  Eigen::MatrixXd x_;     ///< all readings
  Eigen::MatrixXd root_;  ///< lower Cholesky factor of X' M X + prior^-1
  Eigen::VectorXd y_, mean_;
};

}  // namespace trunnion
