#include "testpiece/flank_fit.h"

#include <algorithm>
#include <cmath>

#include "linear_algebra/factors.h"

namespace trunnion {
namespace {

using Row = Eigen::Matrix<double, 1, 5>;

Row row_at(const ConeTrace& trace, double phi, double sine, double cosine) {
  const double c = std::cos(phi), s = std::sin(phi);
  const double lever = trace.h_mm * cosine - trace.nominal_radius_mm * sine;
  return Row(cosine * c, cosine * s, -lever * s, lever * c, 1);
}

}  // namespace

FlankFit fit_flank(std::span<const ConeTrace> traces, Angle half_angle) {
  const double sine = std::sin(half_angle.in_radians()), cosine = std::cos(half_angle.in_radians());
  Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
  Eigen::Matrix<double, 5, 1> right = Eigen::Matrix<double, 5, 1>::Zero();
  for (const ConeTrace& trace : traces)
    for (std::size_t i = 0; i < trace.phi_rad.size(); ++i) {
      const Row row = row_at(trace, trace.phi_rad[i], sine, cosine);
      normal += row.transpose() * row;
      right += row.transpose() * trace.normal_mm[i];
    }
  // The smallest solution: what is not determined stays at zero.
  const SymmetricEigen eigen(normal);
  const Eigen::Matrix<double, 5, 1> d = eigen.eigenvalues();
  const Eigen::Matrix<double, 5, 1> inverse =
      d.unaryExpr([&](double v) { return v > 1e-12 * d.maxCoeff() ? 1 / v : 0.0; });
  const Eigen::Matrix<double, 5, 1> x =
      eigen.eigenvectors() * (inverse.asDiagonal() * (eigen.eigenvectors().transpose() * right));

  FlankFit fit{.shift_mm = x.head<2>(), .tilt_rad = x.segment<2>(2), .size_mm = x[4]};
  double low = 0, high = 0, squares = 0, count = 0;
  for (const ConeTrace& trace : traces) {
    std::vector<double>& residual = fit.residual_mm.emplace_back();
    for (std::size_t i = 0; i < trace.phi_rad.size(); ++i) {
      const double left = trace.normal_mm[i] - row_at(trace, trace.phi_rad[i], sine, cosine).dot(x);
      residual.push_back(left);
      low = count == 0 ? left : std::min(low, left);
      high = count == 0 ? left : std::max(high, left);
      squares += left * left;
      ++count;
    }
  }
  fit.rms_mm = count > 0 ? std::sqrt(squares / count) : 0;
  fit.form_mm = high - low;
  return fit;
}

}  // namespace trunnion
