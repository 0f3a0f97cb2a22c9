#pragma once

#include <Eigen/Core>

namespace trunnion {

/// W with W^T W the pseudo-inverse of `covariance` on what it spans: one row per direction whose variance, with each
/// quantity in units of its own standard deviation, exceeds 1e-9 of the largest. W v has unit covariance.
Eigen::MatrixXd whitening(const Eigen::MatrixXd& covariance);

}  // namespace trunnion
