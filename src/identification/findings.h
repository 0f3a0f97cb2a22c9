#pragma once

#include <span>

#include "identification/identify.h"

namespace trunnion {

/// The eight location errors by generalised least squares on pose errors `delta` (six numbers for each position of `at`
/// in turn, mm and rad) of `covariance`; without symbols where they cannot be told apart.
LocationFinding find_locations(std::span<const IndexedPosition> at, const Eigen::VectorXd& delta,
                               const Eigen::MatrixXd& covariance, const Machine& machine);

/// The twelve errors of a map, each as a whole against zero.
std::vector<ErrorFinding> summarise(const RotaryMapContent& content, char tilt_letter);

}  // namespace trunnion
