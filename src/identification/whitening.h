#pragma once

#include <Eigen/Core>

namespace trunnion {

/// W with W^T W the pseudo-inverse of `covariance` on what it spans: one row per direction whose variance, with each
/// quantity in units of its own standard deviation, exceeds 1e-9 of the largest. W v has unit covariance.
Eigen::MatrixXd whitening(const Eigen::MatrixXd& covariance);

/// G = (X^T V^+ X)^-1 X^T V^+, the generalised least squares estimator of design X and covariance V, X's columns in
/// units of `scale`; empty where the columns cannot be told apart.
Eigen::MatrixXd least_squares_gain(const Eigen::MatrixXd& design, const Eigen::MatrixXd& covariance,
                                   const Eigen::VectorXd& scale);

}  // namespace trunnion
