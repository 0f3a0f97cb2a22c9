#include "errormap/harmonic_surface.h"

#include <cmath>
#include <utility>

#include "error.h"

namespace trunnion {
namespace {

Eigen::VectorXd legendre(int degree, double x) {
  Eigen::VectorXd p(degree + 1);
  p[0] = 1;
  if (degree > 0) p[1] = x;
  for (int n = 1; n < degree; ++n) p[n + 1] = ((2 * n + 1) * x * p[n] - n * p[n - 1]) / (n + 1);
  return p;
}

double scaled(const Range<Angle>& range, Angle a) {
  const double half = 0.5 * (range.high - range.low).in_radians();
  return half > 0 ? (a - range.low).in_radians() / half - 1 : 0;
}

}  // namespace

Eigen::VectorXd HarmonicBasis::tilt_values(Angle a) const { return legendre(tilt_degree, scaled(a_range, a)); }

Eigen::VectorXd HarmonicBasis::turn_values(IndexedPosition position) const {
  const double a = position.a.in_radians(), c = position.c.in_radians();
  const Eigen::VectorXd f =
      (Eigen::Matrix<double, 5, 1>() << 1, std::sin(a), 1 - std::cos(a), std::sin(2 * a), 1 - std::cos(2 * a))
          .finished()
          .head(turn_degree + 1);
  Eigen::VectorXd values(turn_functions());
  values[0] = 1;
  Eigen::Index k = 1;
  for (int h = 1; h <= harmonics; ++h) {
    values.segment(std::exchange(k, k + f.size()), f.size()) = std::cos(h * c) * f;
    values.segment(std::exchange(k, k + f.size()), f.size()) = std::sin(h * c) * f;
  }
  return values;
}

HarmonicSurface::HarmonicSurface(HarmonicBasis basis, Eigen::VectorXd coefficients)
    : basis_(basis), coefficients_(std::move(coefficients)) {
  if (basis_.turn_degree < 0 || basis_.turn_degree > 4)
    throw ModelError("error map: turn_degree " + std::to_string(basis_.turn_degree) + " found, 0 to 4 is wanted");
  if (coefficients_.size() != basis_.coefficient_count())
    throw ModelError("error map: " + std::to_string(coefficients_.size()) + " coefficients, the basis has " +
                     std::to_string(basis_.coefficient_count()));
}

RotaryErrors HarmonicSurface::at(IndexedPosition position) const {
  check(position.a);
  const Eigen::VectorXd t = basis_.tilt_values(position.a), c = basis_.turn_values(position);
  const auto split = [&](Eigen::Index first, const Eigen::VectorXd& values) {
    return PoseError::from_vector(
        Eigen::Map<const Eigen::Matrix<double, 6, Eigen::Dynamic>>(coefficients_.data() + 6 * first, 6, values.size()) *
        values);
  };
  return {split(0, t), split(t.size(), c)};
}

Eigen::Matrix<double, 12, Eigen::Dynamic> HarmonicSurface::jacobian(IndexedPosition position) const {
  check(position.a);
  const Eigen::VectorXd t = basis_.tilt_values(position.a), c = basis_.turn_values(position);
  Eigen::Matrix<double, 12, Eigen::Dynamic> b =
      Eigen::Matrix<double, 12, Eigen::Dynamic>::Zero(12, coefficient_count());
  for (Eigen::Index k = 0; k < t.size(); ++k) b.block<6, 6>(0, 6 * k).diagonal().setConstant(t[k]);
  for (Eigen::Index k = 0; k < c.size(); ++k) b.block<6, 6>(6, 6 * (t.size() + k)).diagonal().setConstant(c[k]);
  return b;
}

}  // namespace trunnion
