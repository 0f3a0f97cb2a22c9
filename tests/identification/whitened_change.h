#pragma once

#include <Eigen/Core>

#include "identification/linear_problem.h"
#include "probing/observation.h"

namespace trunnion::testing {

/// What an effect does to the readings of `problem`, each in units of its standard uncertainty: the same touches of a
/// machine that has it, `with`, against those of one that has not.
inline Eigen::VectorXd whitened_change(const LinearProblem& problem, const ObservationSet& with,
                                       const ObservationSet& without) {
  Eigen::VectorXd z(static_cast<Eigen::Index>(problem.readings.size()));
  Eigen::Index i = 0;
  for (const auto& reading : problem.readings) {
    const Observation &a = with.rows[reading.row], &b = without.rows[reading.row];
    z[i++] = b.direction.dot(a.position_mm - b.position_mm) / reading.sigma;
  }
  return z;
}

}  // namespace trunnion::testing
