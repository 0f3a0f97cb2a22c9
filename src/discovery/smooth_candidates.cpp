#include "discovery/smooth_candidates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "discovery/process_gain.h"
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
    if (column != "repeat") names.push_back(column);
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

bool rotary_angle(const std::string& column) { return column == "A_deg" || column == "B_deg" || column == "C_deg"; }

/// What smooth terms do to the readings, one function a column with the prior of a process of unit variance. The
/// functions are the same in every direction, and the directions whatever the functions: both are kept.
class UnitPriorColumns {
 public:
  explicit UnitPriorColumns(const LinearProblem& problem) : problem_(problem) {}

  Eigen::MatrixXd of(const SmoothTerm& term) {
    if (axes_ != term.axes()) {
      axes_ = term.axes();
      functions_.resize(static_cast<Eigen::Index>(problem_.readings.size()), term.prior_variances().size());
      Eigen::Index i = 0;
      for (const Reading& reading : problem_.readings)
        functions_.row(i++) = term.functions(problem_.situations[reading.row]).transpose();
    }
    const Eigen::RowVectorXd root = term.prior_variances().cwiseSqrt().transpose();
    return (functions_.array().rowwise() * root.array()).colwise() * along(term).array();
  }

 private:
  /// How far a term moves each reading per mm, in units of its sigma.
  const Eigen::VectorXd& along(const SmoothTerm& term) {
    Eigen::VectorXd& known = along_[static_cast<std::size_t>(term.direction())];
    if (known.size() > 0) return known;
    known.resize(static_cast<Eigen::Index>(problem_.readings.size()));
    Eigen::Index i = 0;
    for (const Reading& reading : problem_.readings)
      known[i++] = reading.functional.dot(term.direction_r(problem_.situations[reading.row])) / reading.sigma;
    return known;
  }

  const LinearProblem& problem_;
  std::vector<SmoothAxis> axes_;
  Eigen::MatrixXd functions_;
  std::array<Eigen::VectorXd, std::size(kSmoothDirections)> along_;
};

constexpr double kFirstScale = 0.15;  // of the range: between the finest and the coarsest
constexpr std::size_t kFollowed = 24, kLeading = 4, kLeadingDirections = 3;
constexpr double kLeastVisible = 0.1;   // what hides in the map almost whole would be extrapolated from the rest
constexpr double kSecondCovariate = 4;  // log likelihood that a second covariate must bring

struct Trial {
  std::shared_ptr<const SmoothTerm> term;
  ProcessGain process;
  std::vector<std::size_t> covariates;
  double scale = 0;  ///< of the range
};

/// Tries smooth terms against one base: each covariate and direction at one scale, the best of them at all scales, and
/// products of those that do best alone.
class Trials {
 public:
  Trials(const LinearProblem& problem, const Projection& base, const CandidateScope& scope,
         const std::vector<std::string>& on_measurement)
      : base_(base),
        scope_(scope),
        on_measurement_(on_measurement),
        covariates_(covariates(problem, scope)),
        columns_(problem) {}

  /// All that were tried, those that hide in the base among them.
  std::size_t attempts() const { return attempts_; }

  const std::vector<Trial>& run() {
    for (std::size_t k = 0; k < covariates_.size(); ++k)
      for (const SmoothDirection direction : kSmoothDirections) attempt({k}, direction, kFirstScale);
    sort();
    const std::vector<Trial> first(tried_.begin(),
                                   tried_.begin() + static_cast<std::ptrdiff_t>(std::min(kFollowed, tried_.size())));
    for (const Trial& t : first)
      for (const double scale : {0.01, 0.04, 0.4, 1.0})
        if (scale >= 0.1 || covariates_[t.covariates[0]].fine) attempt(t.covariates, t.term->direction(), scale);
    sort();
    products();
    sort();
    return tried_;
  }

 private:
  /// A column on the measurement is tried along the approach and along its part along Z, others not along that part.
  bool sensible(const std::vector<std::size_t>& which, SmoothDirection direction) const {
    const bool measured = std::ranges::any_of(which, [&](std::size_t k) {
      return std::ranges::find(on_measurement_, covariates_[k].column) != on_measurement_.end();
    });
    if (direction == SmoothDirection::approach) return true;
    return measured == (direction == SmoothDirection::approach_z);
  }

  void attempt(std::vector<std::size_t> which, SmoothDirection direction, double scale) {
    if (!sensible(which, direction)) return;
    std::vector<SmoothAxis> axes;
    for (const std::size_t k : which) {
      const Covariate& c = covariates_[k];
      axes.push_back({c.column, c.low, c.high, scale * (c.high - c.low)});
    }
    const auto term = make_smooth(std::move(axes), direction, scope_.context);
    const ProcessGain process = best_process_gain(base_, columns_.of(*term));
    ++attempts_;
    if (process.visible_fraction > kLeastVisible) tried_.push_back({term, process, std::move(which), scale});
  }

  void products() {
    std::vector<std::size_t> leading;
    std::vector<SmoothDirection> directions;
    for (const Trial& t : tried_) {
      if (leading.size() < kLeading && std::ranges::find(leading, t.covariates[0]) == leading.end())
        leading.push_back(t.covariates[0]);
      if (directions.size() < kLeadingDirections &&
          std::ranges::find(directions, t.term->direction()) == directions.end())
        directions.push_back(t.term->direction());
    }
    std::vector<std::pair<std::size_t, std::size_t>> pairs;
    for (std::size_t i = 0; i < leading.size(); ++i)
      for (std::size_t j = i + 1; j < leading.size(); ++j) pairs.emplace_back(leading[i], leading[j]);
    // What a rotary angle does alone is the map's, so it never leads; what it does with another quantity is not. (The
    // same with the approach, tried on a pretravel that a draught brings to side touches, left the map worse: what it
    // does alone is seen too little.)
    for (std::size_t k = 0; k < covariates_.size() && !leading.empty(); ++k)
      if (rotary_angle(covariates_[k].column) && std::ranges::find(leading, k) == leading.end())
        pairs.emplace_back(leading[0], k);
    for (const auto& [one, other] : pairs)
      for (const SmoothDirection direction : directions) attempt({one, other}, direction, 0.4);
  }

  void sort() {
    std::ranges::stable_sort(tried_, std::greater<>{}, [](const Trial& t) { return t.process.gain; });
  }

  const Projection& base_;
  const CandidateScope& scope_;
  const std::vector<std::string>& on_measurement_;
  std::vector<Covariate> covariates_;
  UnitPriorColumns columns_;
  std::vector<Trial> tried_;
  std::size_t attempts_ = 0;
};

}  // namespace

std::optional<SmoothCandidate> best_smooth_candidate(const LinearProblem& problem, const Projection& base,
                                                     const CandidateScope& scope,
                                                     const std::vector<std::string>& on_measurement, double level) {
  Trials trials(problem, base, scope, on_measurement);
  const std::vector<Trial>& tried = trials.run();
  if (tried.empty()) return std::nullopt;
  const auto attempts = static_cast<double>(trials.attempts());
  const auto single = std::ranges::find_if(tried, [](const Trial& t) { return t.covariates.size() == 1; });
  const Trial* best = &tried.front();
  // Two covariates only where one will not do.
  if (best->covariates.size() == 2 && best->process.gain < single->process.gain + kSecondCovariate) best = &*single;
  // The largest of many gains under noise alone has an exponential tail: 3.6 at 5 % for sixty terms tried.
  const double threshold = 3.6 + std::log(0.05 / level) + std::log(attempts / 60);
  // Where the scatter that would be left is wider than declared, the noise is, and the gain counts in units of that.
  const double left = (base.residual_square() - best->process.explained) / base.freedom();
  const double gain = best->process.gain / std::max(1.0, left);
  if (gain < threshold) return std::nullopt;
  SmoothCandidate found;
  const Eigen::VectorXd root = best->process.amplitude * best->term->prior_variances().cwiseSqrt();
  found.candidate.effect = best->term;
  found.candidate.columns = best->process.amplitude * UnitPriorColumns(problem).of(*best->term);
  found.candidate.scale = root;
  found.candidate.precision = Eigen::VectorXd::Ones(root.size());
  found.candidate.members = attempts;
  found.log_likelihood = gain - std::log(attempts);
  found.p_value = std::min(1.0, level * std::exp(threshold - gain));
  return found;
}

}  // namespace trunnion
