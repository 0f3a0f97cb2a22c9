#include "identification/earlier_map.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "error.h"
#include "identification/whitening.h"
#include "linear_algebra/factors.h"

namespace trunnion {
namespace {

constexpr double kLeastDrift_mm = 1e-7, kLeastDrift_rad = 1e-10;  // keeps a covariance positive definite

constexpr double kRounding = 1e-9;  // of a rewritten function: what another function has no part in

/// A smooth surface with its uncertainty.
struct SmoothMap {
  HarmonicBasis basis;
  Eigen::VectorXd coefficients;
  Eigen::MatrixXd covariance;
  double misfit = 1;
};

HarmonicBasis basis_of_stations(const ErrorGrid& grid) {
  const auto tilts = static_cast<int>(grid.a_stations.size()), turns = static_cast<int>(grid.c_stations.size());
  return {.a_range = {grid.a_stations.front(), grid.a_stations.back()},
          .tilt_degree = tilts < 2 ? 0 : 4,
          .harmonics = std::clamp(turns / 2, turns > 1 ? 1 : 0, 6),
          .turn_degree = std::min(2, tilts - 1)};
}

/// The surface through uncertain nodes: the prior's, given them.
SmoothMap fitted_to_nodes(const RotaryErrorMap& map, const LinearProblem& problem, const SmoothPrior& prior) {
  const RotaryMapContent& content = map.content();
  const KinematicChain& chain = *problem.chain;
  SmoothMap smooth{.basis = basis_of_stations(content.grid)};
  const Eigen::Index m = smooth.basis.coefficient_count();
  const std::size_t columns = content.grid.c_stations.size();
  const auto nodes = static_cast<Eigen::Index>(content.grid.a_stations.size() * columns);
  Eigen::MatrixXd design(6 * nodes, m), from_grid(6 * nodes, content.grid_covariance.rows());
  Eigen::VectorXd delta(6 * nodes);
  for (Eigen::Index k = 0; k < nodes; ++k) {
    Situation s;
    s.at = {content.grid.a_stations[static_cast<std::size_t>(k) / columns],
            content.grid.c_stations[static_cast<std::size_t>(k) % columns]};
    design.middleRows<6>(6 * k) = gauged_basis(chain, smooth.basis, s);
    from_grid.middleRows<6>(6 * k) = map.basis(s);
    delta.segment<6>(6 * k) = map.at(s).vector();
  }
  const Eigen::MatrixXd white = whitening(from_grid * content.grid_covariance * from_grid.transpose());
  const Eigen::VectorXd scale = prior_variances(problem, smooth.basis, prior).cwiseSqrt();
  const Eigen::MatrixXd x = white * design * scale.asDiagonal();  // coefficients in units of their prior
  const Eigen::VectorXd y = white * delta;
  const Cholesky factor(x.transpose() * x + Eigen::MatrixXd::Identity(m, m));
  const Eigen::VectorXd solution = factor.solve(x.transpose() * y);
  const Eigen::MatrixXd inverse = factor.inverse();
  const double effective = (inverse * (x.transpose() * x)).trace();
  const double freedom = static_cast<double>(y.size()) - effective;
  if (freedom > 1) smooth.misfit = std::max(1.0, (y - x * solution).squaredNorm() / freedom);
  smooth.coefficients = scale.cwiseProduct(solution);
  smooth.covariance = smooth.misfit * (scale.asDiagonal() * inverse * scale.asDiagonal());
  return smooth;
}

/// Rewrites Legendre polynomials over one range of the tilt in those over another: exact, the degree being no lower.
Eigen::MatrixXd rewritten_polynomials(const HarmonicBasis& from, const HarmonicBasis& to) {
  const Eigen::Index n = to.tilt_functions();
  Eigen::MatrixXd here(n, n), there(n, from.tilt_functions());
  for (Eigen::Index k = 0; k < n; ++k) {
    const double u = n == 1 ? 0 : std::cos(std::numbers::pi * (static_cast<double>(k) + 0.5) / static_cast<double>(n));
    const Angle a = 0.5 * (to.a_range.low + to.a_range.high) + 0.5 * u * (to.a_range.high - to.a_range.low);
    here.row(k) = to.tilt_values(a);
    there.row(k) = from.tilt_values(a);
  }
  return here.partialPivLu().solve(there);
}

/// New coefficients from old ones, six alike: functions of `to` by functions of `from`.
Eigen::MatrixXd rewritten_functions(const HarmonicBasis& from, const HarmonicBasis& to) {
  Eigen::MatrixXd t =
      Eigen::MatrixXd::Zero(to.tilt_functions() + to.turn_functions(), from.tilt_functions() + from.turn_functions());
  t.topLeftCorner(to.tilt_functions(), from.tilt_functions()) = rewritten_polynomials(from, to);
  t(to.tilt_functions(), from.tilt_functions()) = 1;
  for (int h = 0; h < 2 * from.harmonics; ++h)  // cosine and sine of each
    for (int f = 0; f <= from.turn_degree; ++f)
      t(to.tilt_functions() + 1 + h * (to.turn_degree + 1) + f,
        from.tilt_functions() + 1 + h * (from.turn_degree + 1) + f) = 1;
  return t;
}

HarmonicBasis common_basis(const HarmonicBasis& a, const HarmonicBasis& b) {
  return {.a_range = {std::min(a.a_range.low, b.a_range.low), std::max(a.a_range.high, b.a_range.high)},
          .tilt_degree = std::max(a.tilt_degree, b.tilt_degree),
          .harmonics = std::max(a.harmonics, b.harmonics),
          .turn_degree = std::max(a.turn_degree, b.turn_degree)};
}

/// Variances of the drift: the fall-off of a SmoothPrior, the constants as large as its amplitudes.
Eigen::VectorXd drift_variances(const LinearProblem& problem, const HarmonicBasis& basis, Drift drift) {
  const double length_mm = std::max(drift.length.in_millimetres(), kLeastDrift_mm);
  const double angle_rad = std::max(drift.angle.in_radians(), kLeastDrift_rad);
  const SmoothPrior like{.tilt_um = 1e3 * length_mm,
                         .tilt_urad = 1e6 * angle_rad,
                         .turn_um = 1e3 * length_mm,
                         .turn_urad = 1e6 * angle_rad};
  Eigen::VectorXd variances = prior_variances(problem, basis, like);
  for (const Eigen::Index constant : {Eigen::Index{0}, basis.tilt_functions()}) {
    variances.segment<3>(6 * constant).setConstant(length_mm * length_mm);
    variances.segment<3>(6 * constant + 3).setConstant(angle_rad * angle_rad);
  }
  return variances;
}

}  // namespace

CarriedMap carried_over(const RotaryErrorMap& earlier, const LinearProblem& problem, const HarmonicBasis& wanted,
                        const SmoothPrior& prior, Drift drift) {
  if (!earlier.has_uncertainty())
    throw ModelError("the earlier map has no standard uncertainties: nothing says how far to believe it");
  const RotaryMapContent& content = earlier.content();
  const SmoothMap old = content.smooth_basis
                            ? SmoothMap{*content.smooth_basis, content.smooth_coefficients, content.smooth_covariance}
                            : fitted_to_nodes(earlier, problem, prior);
  CarriedMap carried{.basis = common_basis(old.basis, wanted), .misfit = old.misfit};
  const Eigen::MatrixXd functions = rewritten_functions(old.basis, carried.basis);
  const Eigen::Index m = carried.basis.coefficient_count();
  Eigen::MatrixXd t = Eigen::MatrixXd::Zero(m, old.basis.coefficient_count());
  for (Eigen::Index r = 0; r < functions.rows(); ++r)
    for (Eigen::Index c = 0; c < functions.cols(); ++c)
      t.block<6, 6>(6 * r, 6 * c).diagonal().setConstant(functions(r, c));
  carried.belief.mean = t * old.coefficients;
  carried.belief.covariance = t * old.covariance * t.transpose();
  const Eigen::VectorXd unknown = prior_variances(problem, carried.basis, prior);
  for (Eigen::Index r = 0; r < functions.rows(); ++r)
    if (functions.row(r).cwiseAbs().maxCoeff() < kRounding)
      carried.belief.covariance.diagonal().segment<6>(6 * r) += unknown.segment<6>(6 * r);
  carried.belief.covariance.diagonal() += drift_variances(problem, carried.basis, drift);
  return carried;
}

}  // namespace trunnion
