#include "identification/smooth_fit.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <set>

#include "error.h"
#include "geometric_errors/rotary_errors.h"
#include "identification/minimise.h"
#include "linear_algebra/factors.h"

namespace trunnion {
namespace {

constexpr double kUm = 1e-3, kUrad = 1e-6;  // coefficients are fitted in um and urad

double coefficient_scale(Eigen::Index k) { return k % 6 < 3 ? kUm : kUrad; }

/// Whitened normal equations over [map coefficients | unknowns | extra columns], one set per kind of noise.
struct System {
  Eigen::Index coefficients = 0, size = 0;
  Eigen::MatrixXd normal[2];
  Eigen::VectorXd rhs[2];
  double square[2] = {0, 0};
  double count[2] = {0, 0};
  Eigen::VectorXd extra_precision;  ///< of the last columns, whitened units; empty: free
  Eigen::VectorXd believed_mean;    ///< of the coefficients, and the precision of that; empty: zero and the prior's
  Eigen::MatrixXd believed_precision;
};

/// The prior's degrees of freedom, as logarithms that may take any value.
class Hyperparameters {
 public:
  Hyperparameters(const HarmonicBasis& basis, double sigma_um) : basis_(basis), sigma_um_(sigma_um) {}

  Eigen::Index size() const { return 6 + std::max(0, basis_.harmonics - 1); }

  Eigen::VectorXd pack(const SmoothPrior& p) const {
    Eigen::VectorXd h(size());
    h.head<6>() << std::log(p.tilt_um), std::log(p.tilt_urad), std::log(p.tilt_decay), std::log(p.turn_um),
        std::log(p.turn_urad), std::log(p.turn_decay);
    for (Eigen::Index j = 6; j < h.size(); ++j) {
      const double ratio = static_cast<std::size_t>(j - 6) < p.harmonic_ratio.size()
                               ? p.harmonic_ratio[static_cast<std::size_t>(j - 6)]
                               : 0.5;
      h[j] = std::log(ratio / (1 - ratio));
    }
    return h;
  }
  SmoothPrior unpack(const Eigen::VectorXd& h) const {
    SmoothPrior p{.tilt_um = std::exp(h[0]),
                  .tilt_urad = std::exp(h[1]),
                  .tilt_decay = std::exp(h[2]),
                  .turn_um = std::exp(h[3]),
                  .turn_urad = std::exp(h[4]),
                  .turn_decay = std::exp(h[5])};
    for (Eigen::Index j = 6; j < h.size(); ++j) p.harmonic_ratio.push_back(1 / (1 + std::exp(-h[j])));
    return p;
  }

  /// log variance of each coefficient and its derivative by h.
  void log_variances(const Eigen::VectorXd& h, Eigen::VectorXd& log_variance, Eigen::MatrixXd& derivative) const {
    const Eigen::Index m = basis_.coefficient_count();
    log_variance.resize(m);
    derivative = Eigen::MatrixXd::Zero(m, h.size());
    const double free_um = 2 * std::log(1e4 * sigma_um_), free_urad = 2 * std::log(1e5 * sigma_um_);
    for (Eigen::Index f = 0; f < m / 6; ++f) {
      const bool tilt = f < basis_.tilt_functions();
      for (Eigen::Index k = 0; k < 6; ++k) {
        const Eigen::Index i = 6 * f + k, amplitude = (tilt ? 0 : 3) + (k < 3 ? 0 : 1);
        if (f == 0 || f == basis_.tilt_functions()) {  // constants of the tilting axis and of C
          log_variance[i] = k < 3 ? free_um : free_urad;
          continue;
        }
        const Eigen::Index decay = tilt ? 2 : 5;
        const Eigen::Index g = f - basis_.tilt_functions() - 1;  // C's functions after its constant
        const double degree = static_cast<double>(tilt ? f : g % (basis_.turn_degree + 1));
        log_variance[i] = 2 * h[amplitude] - 2 * std::exp(h[decay]) * degree;
        derivative(i, amplitude) = 2;
        derivative(i, decay) = -2 * std::exp(h[decay]) * degree;
        if (tilt) continue;
        const Eigen::Index harmonic = 1 + g / (2 * (basis_.turn_degree + 1));
        for (Eigen::Index j = 2; j <= harmonic; ++j) {
          const double ratio = 1 / (1 + std::exp(-h[4 + j]));
          log_variance[i] += 2 * std::log(ratio);
          derivative(i, 4 + j) = 2 * (1 - ratio);
        }
      }
    }
    log_variance = log_variance.cwiseMax(-40).cwiseMin(60);
  }

  /// Weak log-normal priors that keep a starved likelihood from running away: minus log density and its gradient.
  double penalty(const Eigen::VectorXd& h, Eigen::VectorXd& gradient) const {
    static const SmoothPrior centre;
    const Eigen::VectorXd at = pack(centre);
    double sum = 0;
    for (Eigen::Index j = 0; j < h.size(); ++j) {
      const double width = j >= 6 ? 1.5 : (j == 2 || j == 5 ? 0.7 : 3.0);
      const double shift = j == 0 || j == 1 || j == 3 || j == 4 ? std::log(sigma_um_ / 0.175) : 0;
      const double z = (h[j] - at[j] - shift) / width;
      sum += 0.5 * z * z;
      gradient[j] += z / width;
    }
    return sum;
  }

 private:
  HarmonicBasis basis_;
  double sigma_um_;
};

struct Evaluation {
  double negative_log = std::numeric_limits<double>::infinity();
  Eigen::VectorXd solution;
  Eigen::VectorXd variance;  ///< diagonal of the inverse
  Eigen::MatrixXd inverse;   ///< where it was asked for
};

enum class Inverse { diagonal, full };

/// An unknown that no reading in use sees stays at zero, and two that are alike share; each in its own scale, for an
/// encoder's zero and a backlash differ by twelve orders of magnitude.
constexpr double kAboveRounding = 1e-12;
double unseen_precision(double precision) { return precision > 0 ? kAboveRounding * precision : 1; }

Evaluation evaluate(const System& system, const Eigen::VectorXd& log_variance, const double noise[2], Inverse wanted) {
  Evaluation e;
  Eigen::MatrixXd joint = Eigen::MatrixXd::Zero(system.size, system.size);
  Eigen::VectorXd rhs = Eigen::VectorXd::Zero(system.size);
  double value = 0;
  const auto m = system.coefficients;
  if (system.believed_mean.size() > 0) {
    const Eigen::VectorXd pull = system.believed_precision * system.believed_mean;
    joint.topLeftCorner(m, m) += system.believed_precision;
    rhs.head(m) += pull;
    value += 0.5 * pull.dot(system.believed_mean);
  } else {
    joint.diagonal().head(m) += (-log_variance).array().exp().matrix();
    value += 0.5 * log_variance.sum();
  }
  for (int c = 0; c < 2; ++c) {
    if (system.count[c] == 0) continue;
    const double w = 1 / (noise[c] * noise[c]);
    joint += w * system.normal[c];
    rhs += w * system.rhs[c];
    value += 0.5 * w * system.square[c] + system.count[c] * std::log(noise[c]);
  }
  if (system.extra_precision.size() > 0) joint.diagonal().tail(system.extra_precision.size()) += system.extra_precision;
  for (Eigen::Index k = system.coefficients; k < system.size; ++k) joint(k, k) += unseen_precision(joint(k, k));
  Cholesky factor(joint);
  if (!factor.definite()) {
    // Of what many readings leave open (mounts against constants of the map) the wide priors are lost to rounding.
    joint.diagonal() *= 1 + kAboveRounding;
    factor = Cholesky(joint);
  }
  if (!factor.definite()) return e;
  e.solution = factor.solve(rhs);
  if (wanted == Inverse::full) {
    e.inverse = factor.inverse();
    e.variance = e.inverse.diagonal();
  } else {
    e.variance = factor.inverse_diagonal();
  }
  value += factor.half_log_determinant() - 0.5 * rhs.dot(e.solution);
  e.negative_log = value;
  return e;
}

/// The system with all but the map's coefficients eliminated, as it stands whatever the prior is; the noise is as
/// declared.
System map_alone(const System& system) {
  const auto m = system.coefficients, others = system.size - m;
  System map{.coefficients = m, .size = m};
  map.normal[0] = Eigen::MatrixXd::Zero(system.size, system.size);
  Eigen::VectorXd rhs = Eigen::VectorXd::Zero(system.size);
  for (int c = 0; c < 2; ++c) {
    if (system.count[c] == 0) continue;
    map.normal[0] += system.normal[c];
    rhs += system.rhs[c];
    map.square[0] += system.square[c];
    map.count[0] += system.count[c];
  }
  map.rhs[0] = rhs.head(m);
  if (others == 0) return map;
  Eigen::MatrixXd among = map.normal[0].bottomRightCorner(others, others);
  if (system.extra_precision.size() > 0) among.diagonal().tail(system.extra_precision.size()) += system.extra_precision;
  for (Eigen::Index k = 0; k < others; ++k) among(k, k) += unseen_precision(among(k, k));
  const Cholesky factor(among);
  const Eigen::MatrixXd shared = factor.half_solve(map.normal[0].bottomLeftCorner(others, m));
  const Eigen::VectorXd of_others = factor.half_solve(rhs.tail(others));
  map.normal[0].conservativeResize(m, m);
  map.normal[0].noalias() -= shared.transpose() * shared;
  map.rhs[0] -= shared.transpose() * of_others;
  // evaluate() halves the square: what the others add to minus the log density is carried there.
  map.square[0] += factor.definite() ? 2 * factor.half_log_determinant() - of_others.squaredNorm()
                                     : std::numeric_limits<double>::infinity();
  return map;
}

/// Whitened rows [map coefficients | unknowns | extra columns]; the basis at one indexed position serves all its
/// readings.
class RowWhitener {
 public:
  RowWhitener(const LinearProblem& problem, const HarmonicBasis& basis, const Eigen::MatrixXd& extra_columns)
      : problem_(problem),
        basis_(basis),
        extra_(extra_columns),
        moves_with_point_(problem.chain->has_rotary(Side::tool)),
        row_(basis.coefficient_count() + static_cast<Eigen::Index>(problem.unknowns.size()) + extra_columns.cols()),
        column_scale_(Eigen::VectorXd::Constant(row_.size(), kUm)) {
    for (Eigen::Index k = 0; k < basis.coefficient_count(); ++k) column_scale_[k] = coefficient_scale(k);
  }

  const Eigen::RowVectorXd& row(Eigen::Index i) {
    const Reading& reading = problem_.readings[static_cast<std::size_t>(i)];
    const Situation& s = problem_.situations[reading.row];
    const Eigen::Index m = basis_.coefficient_count();
    if (!(s.at == last_) || moves_with_point_) {
      at_pose_ = gauged_basis(*problem_.chain, basis_, s);
      last_ = s.at;
    }
    row_.setZero();
    row_.head(m) = reading.functional.transpose() * at_pose_;
    for (const auto& [k, u] : problem_.terms_of(reading)) row_[m + k] += u;
    if (extra_.cols() > 0) row_.tail(extra_.cols()) = extra_.row(i);
    row_ = row_.cwiseProduct(column_scale_.transpose()) / reading.sigma;
    return row_;
  }
  const Eigen::VectorXd& column_scale() const { return column_scale_; }

 private:
  const LinearProblem& problem_;
  const HarmonicBasis& basis_;
  const Eigen::MatrixXd& extra_;
  bool moves_with_point_;
  Eigen::RowVectorXd row_;
  Eigen::VectorXd column_scale_;
  Matrix6Xd at_pose_;
  IndexedPosition last_{Angle::radians(1e9), Angle()};
};

double typical_sigma_um(const LinearProblem& problem) {
  double sum = 0;
  for (const Reading& reading : problem.readings)
    sum += std::log(reading.sigma * (reading.angular ? 100.0 : 1.0) / kUm);
  return problem.readings.empty() ? 1 : std::exp(sum / static_cast<double>(problem.readings.size()));
}

}  // namespace

Eigen::VectorXd prior_variances(const LinearProblem& problem, const HarmonicBasis& basis, const SmoothPrior& prior) {
  const Hyperparameters hyper(basis, typical_sigma_um(problem));
  Eigen::VectorXd log_variance;
  Eigen::MatrixXd derivative;
  hyper.log_variances(hyper.pack(prior), log_variance, derivative);
  Eigen::VectorXd variance = log_variance.array().exp();
  for (Eigen::Index k = 0; k < variance.size(); ++k) variance[k] *= coefficient_scale(k) * coefficient_scale(k);
  return variance;
}

SmoothDesign smooth_design(const LinearProblem& problem, const HarmonicBasis& basis, const SmoothPrior& prior) {
  SmoothDesign design;
  const Eigen::MatrixXd none;
  RowWhitener whitener(problem, basis, none);
  const auto n = static_cast<Eigen::Index>(problem.readings.size());
  design.columns.resize(n, whitener.column_scale().size());
  for (Eigen::Index i = 0; i < n; ++i) design.columns.row(i) = whitener.row(i);
  design.precision = smooth_precision(problem, basis, prior);
  return design;
}

Eigen::VectorXd smooth_precision(const LinearProblem& problem, const HarmonicBasis& basis, const SmoothPrior& prior) {
  const Eigen::VectorXd variance = prior_variances(problem, basis, prior);
  Eigen::VectorXd precision =
      Eigen::VectorXd::Zero(variance.size() + static_cast<Eigen::Index>(problem.unknowns.size()));
  for (Eigen::Index k = 0; k < variance.size(); ++k)
    precision[k] = coefficient_scale(k) * coefficient_scale(k) / variance[k];
  return precision;
}

Matrix6Xd gauged_basis(const KinematicChain& chain, const HarmonicBasis& basis, const Situation& s) {
  const RelativeErrorJacobian j = relative_error_jacobian(chain, s.at, {s.point_r_mm, s.tool_length_mm});
  const Eigen::VectorXd tilt = basis.tilt_values(s.at.a), turn = basis.turn_values(s.at);
  const Eigen::VectorXd tilt0 = basis.tilt_values(Angle()), turn0 = basis.turn_values({});
  Matrix6Xd b(6, basis.coefficient_count());
  for (Eigen::Index k = 0; k < tilt.size(); ++k)
    b.middleCols<6>(6 * k) = tilt[k] * j.here.leftCols<6>() + tilt0[k] * j.reference.leftCols<6>();
  for (Eigen::Index k = 0; k < turn.size(); ++k)
    b.middleCols<6>(6 * (tilt.size() + k)) = turn[k] * j.here.rightCols<6>() + turn0[k] * j.reference.rightCols<6>();
  return b;
}

SmoothFit without_unseen_constants(SmoothFit fit, const KinematicChain& chain) {
  constexpr double kUnseen = 1e-12;  // of the largest eigenvalue: far above rounding, far below what any angle shows
  constexpr int kTilts = 9;
  const HarmonicBasis& basis = fit.basis;
  const Eigen::Index m = basis.coefficient_count();
  Eigen::VectorXd scale(m);
  for (Eigen::Index k = 0; k < m; ++k) scale[k] = coefficient_scale(k);
  Vector6d per_unit;
  per_unit << Eigen::Vector3d::Constant(1 / kUm), Eigen::Vector3d::Constant(1 / kUrad);
  Eigen::MatrixXd shown = Eigen::MatrixXd::Zero(m, m);
  const int turns = 2 * basis.harmonics + 3;
  for (const Eigen::Vector3d& point : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(100, -70, 130)})
    for (int i = 0; i < kTilts; ++i)
      for (int j = 0; j < turns; ++j) {
        Situation s;
        s.at = {basis.a_range.low + (i / (kTilts - 1.0)) * (basis.a_range.high - basis.a_range.low),
                (j / static_cast<double>(turns)) * kFullTurn};
        s.point_r_mm = point;
        const Eigen::MatrixXd b = per_unit.asDiagonal() * gauged_basis(chain, basis, s) * scale.asDiagonal();
        shown.selfadjointView<Eigen::Lower>().rankUpdate(b.transpose());
      }
  const SymmetricEigen eigen(shown);
  const double least = kUnseen * eigen.eigenvalues().maxCoeff();
  Eigen::Index unseen = 0;
  while (unseen < m && eigen.eigenvalues()[unseen] < least) ++unseen;
  const Eigen::MatrixXd away = eigen.eigenvectors().leftCols(unseen);
  const Eigen::MatrixXd keep = scale.asDiagonal() * (Eigen::MatrixXd::Identity(m, m) - away * away.transpose()) *
                               scale.cwiseInverse().asDiagonal();
  fit.coefficients = keep * fit.coefficients;
  fit.covariance = keep * fit.covariance * keep.transpose();
  return fit;
}

HarmonicBasis basis_for(const LinearProblem& problem, int most_harmonics) {
  HarmonicBasis basis{.a_range = {Angle(), Angle()}};
  std::set<long> tilts, turns;  // by the half degree
  for (const PoseGroup& pose : problem.poses) {
    basis.a_range.low = std::min(basis.a_range.low, pose.at.a);
    basis.a_range.high = std::max(basis.a_range.high, pose.at.a);
    tilts.insert(std::lround(2 * pose.at.a.in_degrees()));
    turns.insert(std::lround(2 * pose.at.c.in_degrees()) % 720);
  }
  basis.tilt_degree = tilts.size() < 2 ? 0 : 4;
  basis.turn_degree = std::min<int>(2, static_cast<int>(tilts.size()) - 1);
  basis.harmonics = std::clamp(static_cast<int>(turns.size()) / 2, turns.size() > 1 ? 1 : 0, most_harmonics);
  return basis;
}

SmoothFit fit_smooth(const LinearProblem& problem, const HarmonicBasis& basis, const SmoothOptions& options) {
  const Eigen::Index m = basis.coefficient_count(), unknowns = static_cast<Eigen::Index>(problem.unknowns.size()),
                     extras = options.extra_columns.cols();
  System system{.coefficients = m, .size = m + unknowns + extras};
  for (int c = 0; c < 2; ++c) {
    system.normal[c] = Eigen::MatrixXd::Zero(system.size, system.size);
    system.rhs[c] = Eigen::VectorXd::Zero(system.size);
  }
  const auto n = static_cast<Eigen::Index>(problem.readings.size());
  const auto weight_of = [&](Eigen::Index i) {
    return options.weights.empty() ? 1.0 : options.weights[static_cast<std::size_t>(i)];
  };
  const auto value_of = [&](Eigen::Index i) {
    return options.values.empty() ? problem.readings[static_cast<std::size_t>(i)].value
                                  : options.values[static_cast<std::size_t>(i)];
  };
  if (options.extra_precision.size() > 0) system.extra_precision = kUm * kUm * options.extra_precision;
  if (options.belief) {
    assert(options.prior);
    Eigen::VectorXd per_unit(m);
    for (Eigen::Index k = 0; k < m; ++k) per_unit[k] = 1 / coefficient_scale(k);
    system.believed_mean = per_unit.cwiseProduct(options.belief->mean);
    system.believed_precision =
        Cholesky(per_unit.asDiagonal() * options.belief->covariance * per_unit.asDiagonal()).inverse();
  }
  RowWhitener whitener(problem, basis, options.extra_columns);
  const auto whiten = [&](Eigen::Index i) -> const Eigen::RowVectorXd& { return whitener.row(i); };
  const Eigen::VectorXd& column_scale = whitener.column_scale();
  constexpr Eigen::Index kChunk = 256;
  Eigen::Index passed = 0;  // the readings are gone through twice
  const auto pass = [&](Eigen::Index readings) {
    passed += readings;
    if (options.progress) options.progress(0.5 * static_cast<double>(passed) / static_cast<double>(n));
  };
  Eigen::MatrixXd chunk(kChunk, system.size);
  Eigen::VectorXd chunk_y(kChunk);
  for (int c = 0; c < 2; ++c) {
    Eigen::Index filled = 0;
    const auto flush = [&] {
      if (filled == 0) return;
      system.normal[c].selfadjointView<Eigen::Lower>().rankUpdate(chunk.topRows(filled).transpose());
      system.rhs[c] += chunk.topRows(filled).transpose() * chunk_y.head(filled);
      system.square[c] += chunk_y.head(filled).squaredNorm();
      pass(filled);
      filled = 0;
    };
    for (Eigen::Index i = 0; i < n; ++i) {
      const Reading& reading = problem.readings[static_cast<std::size_t>(i)];
      const double w = weight_of(i);
      if (reading.angular != (c == 1) || w <= 0) continue;
      chunk.row(filled) = std::sqrt(w) * whiten(i);
      chunk_y[filled] = std::sqrt(w) * value_of(i) / reading.sigma;
      ++system.count[c];
      if (++filled == kChunk) flush();
    }
    flush();
    system.normal[c].triangularView<Eigen::StrictlyUpper>() = system.normal[c].transpose();
  }
  const Hyperparameters hyper(basis, typical_sigma_um(problem));

  SmoothFit fit{.basis = basis};
  double noise[2] = {1, 1};
  Eigen::VectorXd log_variance;
  Eigen::MatrixXd derivative;
  if (options.prior) {
    fit.prior = *options.prior;
    noise[0] = fit.prior.length_noise, noise[1] = fit.prior.angle_noise;
    hyper.log_variances(hyper.pack(fit.prior), log_variance, derivative);
  } else {
    const Eigen::Index base = hyper.size();
    const System searched = options.free_noise ? system : map_alone(system);
    const auto objective = [&](const Eigen::VectorXd& h) {
      ValueAndGradient result;
      result.gradient = Eigen::VectorXd::Zero(h.size());
      double scale[2] = {1, 1};
      if (options.free_noise)
        for (int c = 0; c < 2; ++c) scale[c] = std::exp(h[base + c]);
      hyper.log_variances(h.head(base), log_variance, derivative);
      const Evaluation e =
          evaluate(searched, log_variance, scale, options.free_noise ? Inverse::full : Inverse::diagonal);
      result.value = e.negative_log;
      if (!std::isfinite(e.negative_log)) return result;
      const Eigen::VectorXd by_variance =
          0.5 *
          (1 - ((e.variance.head(m).array() + e.solution.head(m).array().square()) * (-log_variance.array()).exp()));
      result.gradient.head(base) = derivative.transpose() * by_variance;
      if (options.free_noise)
        for (int c = 0; c < 2; ++c) {
          if (system.count[c] == 0) continue;
          // d/dlog s: count - (rss + trace(inverse normal)) / s^2
          const double rss =
              system.square[c] - 2 * system.rhs[c].dot(e.solution) + e.solution.dot(system.normal[c] * e.solution);
          result.gradient[base + c] =
              system.count[c] - (rss + e.inverse.cwiseProduct(system.normal[c]).sum()) / (scale[c] * scale[c]);
        }
      Eigen::VectorXd prior_gradient = Eigen::VectorXd::Zero(base);
      result.value += hyper.penalty(h.head(base), prior_gradient);
      result.gradient.head(base) += prior_gradient;
      return result;
    };
    Eigen::VectorXd start = Eigen::VectorXd::Zero(base + (options.free_noise ? 2 : 0));
    start.head(base) = hyper.pack(options.start.value_or(SmoothPrior{}));
    const Minimum found = minimise(objective, start, 1e-3, 80);
    fit.prior = hyper.unpack(found.x.head(base));
    if (options.free_noise)
      for (int c = 0; c < 2; ++c) noise[c] = system.count[c] > 0 ? std::exp(found.x[base + c]) : 1.0;
    fit.prior.length_noise = noise[0], fit.prior.angle_noise = noise[1];
    hyper.log_variances(found.x.head(base), log_variance, derivative);
  }
  const Evaluation e = evaluate(system, log_variance, noise, Inverse::full);
  if (e.solution.size() == 0) throw ModelError("the readings leave more open than any prior of the maps can settle");
  fit.log_evidence = -e.negative_log;
  if (options.belief) {
    const Eigen::VectorXd moved = e.solution.head(m) - system.believed_mean;
    fit.belief_misfit = moved.dot(system.believed_precision * moved);
  }
  const Eigen::VectorXd solution = e.solution.cwiseProduct(column_scale);
  const Eigen::MatrixXd covariance = column_scale.asDiagonal() * e.inverse * column_scale.asDiagonal();
  fit.coefficients = solution.head(m);
  fit.covariance = covariance.topLeftCorner(m, m);
  fit.unknowns = solution.segment(m, unknowns);
  fit.extra = solution.tail(extras);
  fit.extra_covariance = covariance.bottomRightCorner(extras, extras);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Reading& reading = problem.readings[static_cast<std::size_t>(i)];
    const Eigen::RowVectorXd& row = whiten(i);
    if (i % kChunk == 0) pass(std::min(kChunk, n - i));
    const double scale = reading.angular ? noise[1] : noise[0];
    const double z = value_of(i) / reading.sigma - row.dot(e.solution);
    fit.residual.push_back(z * reading.sigma);
    const double w = weight_of(i);
    if (w <= 0) {
      fit.redundancy.push_back(0);
      continue;
    }
    const double leverage = w * (row * e.inverse).dot(row) / (scale * scale);
    fit.redundancy.push_back(std::clamp(1 - leverage, 0.0, 1.0));
    fit.effective_parameters += leverage;
    fit.weighted_rss += w * z * z / (scale * scale);
    ++fit.readings;
  }
  return fit;
}

}  // namespace trunnion
