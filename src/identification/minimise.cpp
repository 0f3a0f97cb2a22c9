#include "identification/minimise.h"

#include <cmath>

namespace trunnion {

Minimum minimise(const std::function<ValueAndGradient(const Eigen::VectorXd&)>& function, const Eigen::VectorXd& start,
                 double tolerance, int most) {
  const Eigen::Index n = start.size();
  Eigen::VectorXd x = start;
  ValueAndGradient here = function(x);
  Minimum best{x, here.value, 1};
  Eigen::MatrixXd inverse_hessian = Eigen::MatrixXd::Identity(n, n) / std::max(1.0, here.gradient.norm());
  while (best.evaluations < most) {
    Eigen::VectorXd step = -(inverse_hessian * here.gradient);
    double slope = step.dot(here.gradient);
    if (!(slope < 0)) {
      inverse_hessian = Eigen::MatrixXd::Identity(n, n) / std::max(1.0, here.gradient.norm());
      step = -(inverse_hessian * here.gradient);
      slope = step.dot(here.gradient);
      if (!(slope < 0)) break;
    }
    constexpr double kLongest = 3;  // the functions minimised here live on logarithms
    if (const double length = step.cwiseAbs().maxCoeff(); length > kLongest)
      step *= kLongest / length, slope *= kLongest / length;
    ValueAndGradient there;
    double t = 1;
    bool lower = false;
    for (; best.evaluations < most && t > 1e-6; t *= 0.4) {
      there = function(x + t * step);
      ++best.evaluations;
      if (std::isfinite(there.value) && there.value <= here.value + 1e-4 * t * slope) {
        lower = true;
        break;
      }
    }
    if (!lower) break;
    const Eigen::VectorXd s = t * step, y = there.gradient - here.gradient;
    const double gain = here.value - there.value, sy = s.dot(y);
    if (sy > 1e-12 * s.norm() * y.norm()) {
      const Eigen::VectorXd hy = inverse_hessian * y;
      inverse_hessian +=
          ((sy + y.dot(hy)) / (sy * sy)) * s * s.transpose() - (hy * s.transpose() + s * hy.transpose()) / sy;
    }
    x += s;
    here = there;
    best.x = x;
    best.value = here.value;
    if (gain < tolerance) break;
  }
  return best;
}

}  // namespace trunnion
