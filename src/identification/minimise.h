#pragma once

#include <Eigen/Core>
#include <functional>

namespace trunnion {

/// Value of a smooth function at x, with its gradient.
struct ValueAndGradient {
  double value = 0;
  Eigen::VectorXd gradient;
};

/// Where minimise() ended, and after how many evaluations.
struct Minimum {
  Eigen::VectorXd x;
  double value = 0;
  int evaluations = 0;
};

/// A local minimum from `start` by BFGS with backtracking (Nocedal & Wright, Numerical Optimization, 2nd ed., ch. 6).
/// Ends when an iteration gains less than `tolerance`, or after `most` evaluations; a value that is not finite is
/// backed away from.
Minimum minimise(const std::function<ValueAndGradient(const Eigen::VectorXd&)>& function, const Eigen::VectorXd& start,
                 double tolerance, int most);

}  // namespace trunnion
