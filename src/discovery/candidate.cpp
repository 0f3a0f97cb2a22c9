#include "discovery/candidate.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "identification/distributions.h"

namespace trunnion {
namespace {

constexpr double kVisible = 1e-3;  // of a column's norm: less than that outside the base is rounding

/// Z' P Z on its visible directions: whitening W with W' (Z' P Z) W = I.
struct VisibleSpace {
  Eigen::MatrixXd whitening;
  double visible_fraction = 0;
};
VisibleSpace visible_space(const Eigen::MatrixXd& z, const Eigen::MatrixXd& projected) {
  VisibleSpace space;
  const Eigen::VectorXd norms = z.colwise().norm().transpose();
  const double total = z.squaredNorm();
  if (total <= 0) {
    space.whitening.resize(z.cols(), 0);
    return space;
  }
  const Eigen::VectorXd unit = norms.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
  const Eigen::MatrixXd gram = unit.asDiagonal() * (z.transpose() * projected) * unit.asDiagonal();
  space.visible_fraction = std::sqrt(std::max(0.0, z.cwiseProduct(projected).sum() / total));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(0.5 * (gram + gram.transpose()));
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < gram.rows(); ++k)
    if (eigen.eigenvalues()[k] > kVisible * kVisible) kept.push_back(k);
  space.whitening.resize(z.cols(), static_cast<Eigen::Index>(kept.size()));
  for (std::size_t k = 0; k < kept.size(); ++k)
    space.whitening.col(static_cast<Eigen::Index>(k)) =
        unit.cwiseProduct(eigen.eigenvectors().col(kept[k])) / std::sqrt(eigen.eigenvalues()[kept[k]]);
  return space;
}

CandidateScore score_of(const Projection& base, const Eigen::MatrixXd& z, const Eigen::MatrixXd& projected) {
  CandidateScore s;
  const VisibleSpace space = visible_space(z, projected);
  s.visible_fraction = space.visible_fraction;
  s.rank = static_cast<double>(space.whitening.cols());
  if (s.rank == 0 || base.freedom() <= s.rank) return s;
  s.gain = (space.whitening.transpose() * (z.transpose() * base.residual())).squaredNorm();
  const double rest = std::max(1e-12 * base.residual_square(), base.residual_square() - s.gain);
  s.p_value = f_tail(s.gain / s.rank / (rest / (base.freedom() - s.rank)), s.rank, base.freedom() - s.rank);
  s.log_likelihood = 0.5 * s.gain;
  return s;
}

}  // namespace

Eigen::MatrixXd effect_columns(const LinearProblem& problem, const Effect& effect) {
  const auto n = static_cast<Eigen::Index>(problem.readings.size());
  const auto m = static_cast<Eigen::Index>(effect.parameters().size());
  Eigen::RowVectorXd units(m);
  for (Eigen::Index k = 0; k < m; ++k) units[k] = from_unit(1, effect.parameters()[static_cast<std::size_t>(k)].unit);
  Eigen::MatrixXd columns(n, m);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Reading& reading = problem.readings[static_cast<std::size_t>(i)];
    columns.row(i) =
        (reading.functional.transpose() * effect.basis(problem.situations[reading.row])).cwiseProduct(units) /
        reading.sigma;
  }
  return columns;
}

Candidate make_candidate(const LinearProblem& problem, EffectPtr effect) {
  Candidate candidate{.columns = effect_columns(problem, *effect)};
  candidate.scale.resize(static_cast<Eigen::Index>(effect->parameters().size()));
  for (std::size_t k = 0; k < effect->parameters().size(); ++k)
    candidate.scale[static_cast<Eigen::Index>(k)] = from_unit(1, effect->parameters()[k].unit);
  candidate.effect = std::move(effect);
  return candidate;
}

CandidateScore score(const Projection& base, const Eigen::MatrixXd& columns) {
  return score_of(base, columns, base.apply(columns));
}

std::vector<CandidateScore> scores(const Projection& base, const std::vector<Candidate>& candidates) {
  Eigen::Index total = 0;
  for (const Candidate& c : candidates) total += c.columns.cols();
  Eigen::MatrixXd all(candidates.empty() ? 0 : candidates.front().columns.rows(), total);
  Eigen::Index at = 0;
  for (const Candidate& c : candidates) {
    all.middleCols(at, c.columns.cols()) = c.columns;
    at += c.columns.cols();
  }
  const Eigen::MatrixXd projected = base.apply(all);
  std::vector<CandidateScore> result;
  at = 0;
  for (const Candidate& c : candidates) {
    result.push_back(score_of(base, c.columns, projected.middleCols(at, c.columns.cols())));
    at += c.columns.cols();
  }
  return result;
}

std::vector<double> canonical_correlations(const Projection& base, const Candidate& candidate,
                                           const std::vector<Candidate>& others) {
  const Eigen::MatrixXd projected = base.apply(candidate.columns);
  const VisibleSpace own = visible_space(candidate.columns, projected);
  const Eigen::MatrixXd direction = projected * own.whitening;  // (P Z1) W1
  Eigen::Index total = 0;
  for (const Candidate& other : others) total += other.columns.cols();
  Eigen::MatrixXd all(candidate.columns.rows(), total);
  Eigen::Index at = 0;
  for (const Candidate& other : others) {
    all.middleCols(at, other.columns.cols()) = other.columns;
    at += other.columns.cols();
  }
  const Eigen::MatrixXd all_projected = base.apply(all);
  const Eigen::MatrixXd cross = direction.transpose() * all;
  std::vector<double> correlations;
  at = 0;
  for (const Candidate& other : others) {
    const Eigen::Index m = other.columns.cols();
    const VisibleSpace space = visible_space(other.columns, all_projected.middleCols(at, m));
    const Eigen::MatrixXd c = cross.middleCols(at, m) * space.whitening;
    at += m;
    if (c.size() == 0) {
      correlations.push_back(0);
      continue;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(c * c.transpose());
    correlations.push_back(std::sqrt(std::clamp(eigen.eigenvalues().maxCoeff(), 0.0, 1.0)));
  }
  return correlations;
}

Candidate refined(const LinearProblem& problem, const Projection& base, const Candidate& candidate) {
  const std::vector<Parameter> shape = candidate.effect->shape();
  const std::vector<ShapeRange> ranges = candidate.effect->shape_ranges();
  Candidate best = candidate;
  double best_gain = score(base, best.columns).gain;
  Eigen::VectorXd x(static_cast<Eigen::Index>(shape.size()));
  for (std::size_t k = 0; k < shape.size(); ++k) x[static_cast<Eigen::Index>(k)] = shape[k].value;
  // Coordinate search with a shrinking step: the profile of a shape is smooth but has more than one summit.
  for (std::size_t k = 0; k < shape.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    if (ranges[k].whole) continue;
    const bool positive = ranges[k].low > 0;  // a period or time constant: steps are factors
    double step = positive ? 0.35 : 0.1 * (ranges[k].high - ranges[k].low);
    for (int round = 0; round < 9; ++round, step *= 0.5)
      for (const double sign : {-1.0, 1.0}) {
        Eigen::VectorXd there = x;
        there[i] =
            std::clamp(positive ? x[i] * std::exp(sign * step) : x[i] + sign * step, ranges[k].low, ranges[k].high);
        const EffectPtr moved = candidate.effect->with_shape(there);
        Candidate tried = make_candidate(problem, moved);
        const double gain = score(base, tried.columns).gain;
        if (gain > best_gain) best_gain = gain, best = std::move(tried), x = there;
      }
  }
  return best;
}

}  // namespace trunnion
