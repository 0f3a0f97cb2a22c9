#include "discovery/process_gain.h"

#include <cmath>

#include "linear_algebra/factors.h"

namespace trunnion {

ProcessGain best_process_gain(const Projection& base, const Eigen::MatrixXd& z) {
  const Eigen::MatrixXd used = base.mask().asDiagonal() * z, reduced = base.reduced(z);
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(z.cols(), z.cols());
  gram.selfadjointView<Eigen::Lower>().rankUpdate(used.transpose());
  gram.selfadjointView<Eigen::Lower>().rankUpdate(reduced.transpose(), -1);
  const SymmetricEigen eigen(gram);
  const Eigen::ArrayXd g = eigen.eigenvalues().array().max(0);
  const Eigen::ArrayXd b = (eigen.eigenvectors().transpose() * (z.transpose() * base.residual())).array();
  const Eigen::ArrayXd b2 = b.square();
  const auto gain_at = [&](double log_amplitude) {
    const double a = std::exp(2 * log_amplitude);
    return 0.5 * (b2 * a / (1 + a * g) - (1 + a * g).log()).sum();
  };
  // No more than so many times what is left to explain: a place that was read is off by the very errors that are sought,
  // and functions of it that were steep enough would explain each reading by itself.
  constexpr double kSteepest = 30;
  const double left = std::sqrt(base.residual_square()), size = used.norm();
  if (!(size > 0)) return {};
  const double most = std::min(std::log(0.2), std::log(kSteepest * left / size));
  ProcessGain best;
  double at = 0;
  for (double log_amplitude = std::log(1e-5); log_amplitude < most; log_amplitude += 0.5)
    if (const double gain = gain_at(log_amplitude); gain > best.gain) best.gain = gain, at = log_amplitude;
  if (best.gain <= 0) return best;
  for (double step = 0.25; step > 0.05; step /= 2)
    for (const double there : {at - step, at + step})
      if (const double gain = gain_at(there); there < most && gain > best.gain) best.gain = gain, at = there;
  best.amplitude = std::exp(at);
  const double a = best.amplitude * best.amplitude;
  best.explained = (b2 * a / (1 + a * g)).sum();
  const Eigen::VectorXd found =
      eigen.eigenvectors() * (b * (a / (1 + a * g))).matrix();  // its coefficients, given the readings
  const Eigen::VectorXd signal = used * found;
  best.visible_fraction = std::sqrt(std::max(0.0, 1 - (reduced * found).squaredNorm() / signal.squaredNorm()));
  return best;
}

}  // namespace trunnion
