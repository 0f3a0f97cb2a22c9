#include "discovery/smooth_candidates.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "model/effects/smooth.h"

namespace trunnion {
namespace {

/// A covariate that a smooth effect may depend on, with the range that the readings span.
struct Covariate {
  std::string column;
  double low = 0, high = 0;
  bool fine = false;  ///< may vary many times over its range: time and order
};

std::vector<Covariate> covariates(const LinearProblem& problem, const CandidateScope& scope) {
  std::vector<std::string> names = {"x_mm",    "y_mm",  "z_mm",
                                    "xw_mm",   "yw_mm", "zw_mm",
                                    "phi_deg", "nz",    std::string(1, scope.context.tilt_letter) + "_deg",
                                    "C_deg"};
  for (const std::string& column : scope.columns)
    if (column != "A_dir" && column != "B_dir" && column != "C_dir" && column != "repeat") names.push_back(column);
  if (std::ranges::find(names, "time_s") == names.end()) names.push_back("order");
  std::vector<Covariate> found;
  for (const std::string& name : names) {
    Covariate c{name, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    c.fine = name == "time_s" || name == "order";
    for (const Reading& reading : problem.readings)
      if (const auto value = smooth_covariate(name, problem.situations[reading.row], *problem.chain)) {
        c.low = std::min(c.low, *value);
        c.high = std::max(c.high, *value);
      }
    if (c.high - c.low > 1e-9 * (1 + std::abs(c.high))) found.push_back(c);
  }
  return found;
}

/// Gain in restricted log likelihood of a process with columns Z (unit prior), over its amplitude:
///   -1/2 log det(I + a G) + 1/2 b' (I/a + G)^-1 b,   G = Z' P Z, b = Z' P y, noise as declared.
struct AmplitudeGain {
  double gain = 0;
  double amplitude = 0;  ///< standard deviation of the process, in units of a column
};
AmplitudeGain best_amplitude(const Projection& base, const Eigen::MatrixXd& z) {
  const Eigen::MatrixXd gram = z.transpose() * base.apply(z);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(0.5 * (gram + gram.transpose()));
  const Eigen::VectorXd b = eigen.eigenvectors().transpose() * (z.transpose() * base.residual());
  AmplitudeGain best;
  for (double log_amplitude = std::log(1e-5); log_amplitude < std::log(0.2); log_amplitude += 0.25) {
    const double a = std::exp(2 * log_amplitude);
    double gain = 0;
    for (Eigen::Index k = 0; k < b.size(); ++k) {
      const double g = std::max(0.0, eigen.eigenvalues()[k]);
      gain += -0.5 * std::log1p(a * g) + 0.5 * b[k] * b[k] * a / (1 + a * g);
    }
    if (gain > best.gain) best = {gain, std::exp(log_amplitude)};
  }
  return best;
}

struct Tried {
  std::shared_ptr<const SmoothTerm> term;
  AmplitudeGain amplitude;
  std::vector<std::size_t> covariates;
};

Eigen::MatrixXd unit_prior_columns(const LinearProblem& problem, const SmoothTerm& term) {
  const Eigen::VectorXd root = term.prior_variances().cwiseSqrt();
  Eigen::MatrixXd z(static_cast<Eigen::Index>(problem.readings.size()), root.size());
  for (Eigen::Index i = 0; i < z.rows(); ++i) {
    const Reading& reading = problem.readings[static_cast<std::size_t>(i)];
    const Situation& s = problem.situations[reading.row];
    const double along = reading.functional.head<3>().dot(term.direction_r(s));
    z.row(i) = (along / reading.sigma) * term.functions(s).cwiseProduct(root).transpose();
  }
  return z;
}

}  // namespace

std::optional<SmoothCandidate> best_smooth_candidate(const LinearProblem& problem, const Projection& base,
                                                     const CandidateScope& scope, double level) {
  const std::vector<Covariate> columns = covariates(problem, scope);
  constexpr SmoothDirection kDirections[] = {
      SmoothDirection::x,       SmoothDirection::y,       SmoothDirection::z,       SmoothDirection::table_x,
      SmoothDirection::table_y, SmoothDirection::table_z, SmoothDirection::approach};
  std::vector<Tried> tried;
  const auto try_term = [&](std::vector<SmoothAxis> axes, SmoothDirection direction, std::vector<std::size_t> which) {
    const auto term = make_smooth(std::move(axes), direction, scope.context);
    tried.push_back({term, best_amplitude(base, unit_prior_columns(problem, *term)), std::move(which)});
  };
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const Covariate& c = columns[k];
    std::vector<double> scales = {0.15, 0.4, 1};
    if (c.fine) scales.insert(scales.begin(), 0.04);
    for (const double scale : scales)
      for (const SmoothDirection direction : kDirections)
        try_term({{c.column, c.low, c.high, scale * (c.high - c.low)}}, direction, {k});
  }
  if (tried.empty()) return std::nullopt;
  const auto better = [](const Tried& a, const Tried& b) { return a.amplitude.gain > b.amplitude.gain; };
  std::ranges::sort(tried, better);
  // Products of the covariates that do best alone, along the directions that do best.
  std::vector<std::size_t> leading;
  std::vector<SmoothDirection> directions;
  for (const Tried& t : tried) {
    if (leading.size() < 4 && std::ranges::find(leading, t.covariates[0]) == leading.end())
      leading.push_back(t.covariates[0]);
    if (directions.size() < 3 && std::ranges::find(directions, t.term->direction()) == directions.end())
      directions.push_back(t.term->direction());
  }
  const double best_single = tried.front().amplitude.gain;
  for (std::size_t i = 0; i < leading.size(); ++i)
    for (std::size_t j = i + 1; j < leading.size(); ++j)
      for (const SmoothDirection direction : directions) {
        const Covariate &a = columns[leading[i]], &b = columns[leading[j]];
        try_term({{a.column, a.low, a.high, 0.4 * (a.high - a.low)}, {b.column, b.low, b.high, 0.4 * (b.high - b.low)}},
                 direction, {leading[i], leading[j]});
      }
  std::ranges::sort(tried, better);
  const Tried* best = &tried.front();
  // Two covariates only where one will not do.
  if (best->covariates.size() == 2 && best->amplitude.gain < best_single + 4)
    for (const Tried& t : tried)
      if (t.covariates.size() == 1) {
        best = &t;
        break;
      }
  // The largest of many gains under noise alone has an exponential tail: 3.6 at 5 % for sixty terms tried.
  const double threshold = 3.6 + std::log(0.05 / level) + std::log(static_cast<double>(tried.size()) / 60);
  if (best->amplitude.gain < threshold) return std::nullopt;
  SmoothCandidate found;
  const Eigen::VectorXd root = best->amplitude.amplitude * best->term->prior_variances().cwiseSqrt();
  found.candidate.effect = best->term;
  found.candidate.columns = best->amplitude.amplitude * unit_prior_columns(problem, *best->term);
  found.candidate.scale = root;
  found.candidate.precision = Eigen::VectorXd::Ones(root.size());
  found.log_likelihood = best->amplitude.gain;
  found.p_value = std::min(1.0, level * std::exp(threshold - best->amplitude.gain));
  return found;
}

}  // namespace trunnion
