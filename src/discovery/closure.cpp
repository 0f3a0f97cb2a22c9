#include "discovery/closure.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "discovery/smooth_candidates.h"
#include "error.h"
#include "identification/distributions.h"
#include "identification/map_grid.h"
#include "model/effects/rotary_error_map.h"

namespace trunnion {
namespace {

constexpr double kNotSeparable = 0.95, kPartlySeparable = 0.5;

double whitened_rms_um(const LinearProblem& problem, const std::vector<double>& residual,
                       const std::vector<bool>& rows) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < residual.size(); ++i) {
    if (!rows[i]) continue;
    sum += std::pow(residual[i] * (problem.readings[i].angular ? 100 : 1), 2);
    ++count;
  }
  return count > 0 ? 1e3 * std::sqrt(sum / count) : 0;
}

/// Which readings serve for what; decided by position in the files alone, before anything is looked at.
struct Split {
  std::vector<bool> search;              ///< per reading
  std::vector<bool> holdout;             ///< per reading; all false without verification
  std::vector<std::vector<bool>> folds;  ///< without verification: the held-out readings of each fold
};

Split split_by_poses(const LinearProblem& problem, std::size_t verification_from, int folds) {
  Split split;
  const std::size_t n = problem.readings.size();
  split.search.assign(n, true);
  split.holdout.assign(n, false);
  const bool verified = verification_from < problem.observations->rows.size();
  // Visits: a pose that the machine comes back to in the verification is another visit.
  std::vector<std::size_t> visit_of(n);
  std::vector<bool> reference_visit, verification_visit;
  for (std::size_t i = 0, visit = 0; i < n; ++i) {
    const Reading& reading = problem.readings[i];
    const bool verification = reading.row >= verification_from;
    const bool moved = i == 0 || reading.pose != problem.readings[i - 1].pose ||
                       verification != (problem.readings[i - 1].row >= verification_from);
    if (moved && i > 0) ++visit;
    visit_of[i] = visit;
    if (moved) {
      reference_visit.push_back(problem.poses[reading.pose].reference);
      verification_visit.push_back(verification);
    }
  }
  if (verified) {
    // Every third pose of the verification is kept back, the reference pose never.
    std::size_t counted = 0;
    std::vector<bool> held(reference_visit.size(), false);
    for (std::size_t v = 0; v < held.size(); ++v)
      if (verification_visit[v] && !reference_visit[v]) held[v] = counted++ % 3 == 1;
    for (std::size_t i = 0; i < n; ++i) {
      split.holdout[i] = held[visit_of[i]];
      split.search[i] = !split.holdout[i];
    }
  } else {
    for (int f = 0; f < folds; ++f) {
      std::vector<bool> out(n, false);
      for (std::size_t i = 0; i < n; ++i)
        out[i] = !problem.poses[problem.readings[i].pose].reference &&
                 static_cast<int>(problem.readings[i].pose) % folds == f;
      if (std::ranges::any_of(out, [](bool b) { return b; })) split.folds.push_back(std::move(out));
    }
  }
  return split;
}

/// Squared prediction errors of hold-out readings, summed by pose.
struct HoldoutError {
  std::vector<double> by_pose;  ///< mean square of each held-out pose, in units of sigma^2
  double rms_um = 0;
};

/// The search as it stands: data, base, effects accepted so far.
class Search {
 public:
  Search(const ObservationSet& all, std::size_t verification_from, const Machine& machine,
         const ClosureOptions& options)
      : options_(options), machine_(machine) {
    result_.problem = make_linear_problem(all, machine);
    split_ = split_by_poses(problem(), verification_from, options.folds);
    basis_ = basis_for(problem());
    y_.resize(static_cast<Eigen::Index>(problem().readings.size()));
    for (Eigen::Index i = 0; i < y_.size(); ++i) {
      const Reading& reading = problem().readings[static_cast<std::size_t>(i)];
      y_[i] = reading.value / reading.sigma;
    }
    used_.assign(problem().readings.size(), true);
    collect_candidates(all);
  }

  ClosureResult run() {
    result_.has_holdout = std::ranges::any_of(split_.holdout, [](bool b) { return b; });
    result_.holdout = split_.holdout;
    double sum = 0;
    for (const Reading& reading : problem().readings) sum += std::pow(reading.sigma * (reading.angular ? 100 : 1), 2);
    result_.noise_um = 1e3 * std::sqrt(sum / static_cast<double>(problem().readings.size()));
    find_chips();
    fit_base();
    while (static_cast<int>(accepted_.size()) < options_.most_effects && step()) {
    }
    check_backward();
    finish();
    return std::move(result_);
  }

 private:
  const LinearProblem& problem() const { return result_.problem; }

  void collect_candidates(const ObservationSet& all) {
    CandidateScope scope{.context = effect_context(machine_), .readings = problem().situations};
    if (all.has_time) scope.columns.push_back("time_s");
    if (all.has_temperature) scope.columns.push_back("temperature_C");
    if (all.has_tilt_sense) scope.columns.push_back(std::string(1, machine_.tilt_letter()) + "_dir");
    if (all.has_turn_sense) scope.columns.push_back("C_dir");
    if (all.has_repeat) scope.columns.push_back("repeat");
    for (const std::string& column : all.extra_columns) scope.columns.push_back(column);
    for (const std::string& artifact : all.artifacts)
      if (!artifact.empty()) scope.artifacts.push_back(artifact);
    for (const Family& family : catalogue()) {
      const std::vector<EffectPtr> found = family.candidates(scope);
      if (found.empty() && family.name != "rotary_error_map" && family.name != "location_errors")
        result_.untestable.push_back({std::string(family.name), std::string(family.remedy)});
      for (const EffectPtr& effect : found) candidates_.push_back(make_candidate(problem(), effect));
    }
    for (const Candidate& c : candidates_) result_.columns_scanned += static_cast<std::size_t>(c.columns.cols());
    scope_ = scope;
  }

  std::vector<bool> searched() const {
    std::vector<bool> rows = split_.search;
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = rows[i] && used_[i];
    return rows;
  }

  Eigen::MatrixXd accepted_columns(std::size_t without = static_cast<std::size_t>(-1)) const {
    Eigen::Index total = 0;
    for (std::size_t k = 0; k < accepted_.size(); ++k)
      if (k != without) total += accepted_[k].columns.cols();
    Eigen::MatrixXd columns(y_.size(), total);
    Eigen::Index at = 0;
    for (std::size_t k = 0; k < accepted_.size(); ++k) {
      if (k == without) continue;
      columns.middleCols(at, accepted_[k].columns.cols()) = accepted_[k].columns;
      at += accepted_[k].columns.cols();
    }
    return columns;
  }

  Eigen::VectorXd accepted_precision(std::size_t without = static_cast<std::size_t>(-1)) const {
    std::vector<double> all;
    for (std::size_t k = 0; k < accepted_.size(); ++k)
      if (k != without) append_precision(all, accepted_[k]);
    return Eigen::Map<Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
  }
  static void append_precision(std::vector<double>& all, const Candidate& c) {
    for (Eigen::Index j = 0; j < c.columns.cols(); ++j) all.push_back(c.precision.size() > 0 ? c.precision[j] : 0.0);
  }

  /// Columns of effects in a fit, with their priors.
  struct Extras {
    Eigen::MatrixXd columns;
    Eigen::VectorXd precision;
  };
  Extras accepted_extras(std::size_t without = static_cast<std::size_t>(-1)) const {
    return {accepted_columns(without), accepted_precision(without)};
  }
  Extras extended(const Candidate& candidate) const {
    Extras e = accepted_extras();
    Extras both{Eigen::MatrixXd(y_.size(), e.columns.cols() + candidate.columns.cols()), {}};
    both.columns << e.columns, candidate.columns;
    std::vector<double> precision(e.precision.data(), e.precision.data() + e.precision.size());
    append_precision(precision, candidate);
    both.precision = Eigen::Map<Eigen::VectorXd>(precision.data(), static_cast<Eigen::Index>(precision.size()));
    return both;
  }
  Extras no_extras() const { return {Eigen::MatrixXd(y_.size(), 0), Eigen::VectorXd()}; }

  SmoothOptions smooth_options(const std::vector<bool>& rows, const Extras& extras) const {
    SmoothOptions o;
    for (const bool r : rows) o.weights.push_back(r ? 1.0 : 0.0);
    o.extra_columns = extras.columns;
    o.extra_precision = extras.precision;
    for (Eigen::Index i = 0; i < extras.columns.rows(); ++i)  // unwhitened: fit_smooth divides by sigma itself
      o.extra_columns.row(i) *= problem().readings[static_cast<std::size_t>(i)].sigma;
    return o;
  }

  /// Sparse far-off readings, judged in the model with what was accepted so far. A crowd is not removed: it is an
  /// effect.
  void find_chips() {
    SmoothOptions o = smooth_options(std::vector<bool>(static_cast<std::size_t>(y_.size()), true), accepted_extras());
    OutlierSearch search = find_outliers(problem(), basis_, o);
    used_ = search.used;
  }

  void fit_base() {
    const SmoothOptions o = smooth_options(searched(), accepted_extras());
    prior_ = fit_smooth(problem(), basis_, o).prior;
    const ProjectionInput input = projection_input(searched(), accepted_extras());
    free_ = problem().has_pose_kind ? nullptr : std::make_unique<FreePoseProjection>(input);
    smooth_ = std::make_unique<SmoothProjection>(input, basis_, prior_);
  }

  ProjectionInput projection_input(const std::vector<bool>& rows, const Extras& extras) const {
    return {&problem(), rows, y_, extras.columns, extras.precision};
  }

  double multiplicity() const { return 2 * static_cast<double>(std::max<std::size_t>(1, result_.columns_scanned)); }

  /// Prediction of held-out poses by a smooth map with `columns` as further effects, fitted to the rest.
  HoldoutError holdout_error(const Extras& columns) const {
    HoldoutError error;
    double sum_um = 0, count_um = 0;
    std::vector<double> sum(problem().poses.size(), 0), count(problem().poses.size(), 0);
    const auto predict = [&](const std::vector<bool>& out) {
      std::vector<bool> rows(out.size());
      for (std::size_t i = 0; i < out.size(); ++i) rows[i] = !out[i] && used_[i];
      SmoothOptions o = smooth_options(rows, columns);
      o.prior = prior_;
      const SmoothFit fit = fit_smooth(problem(), basis_, o);
      for (std::size_t i = 0; i < out.size(); ++i) {
        if (!out[i] || !used_[i]) continue;
        const Reading& reading = problem().readings[i];
        sum[reading.pose] += std::pow(fit.residual[i] / reading.sigma, 2);
        ++count[reading.pose];
        sum_um += std::pow(fit.residual[i] * (reading.angular ? 1e5 : 1e3), 2);
        ++count_um;
      }
    };
    if (result_.has_holdout)
      predict(split_.holdout);
    else
      for (const std::vector<bool>& fold : split_.folds) predict(fold);
    for (std::size_t p = 0; p < sum.size(); ++p)
      if (count[p] > 0) error.by_pose.push_back(sum[p] / count[p]);
    error.rms_um = count_um > 0 ? std::sqrt(sum_um / count_um) : 0;
    return error;
  }

  /// Whether the hold-out error falls by more than the standard error of its fall, pose by pose.
  static bool falls(const HoldoutError& before, const HoldoutError& after) {
    const std::size_t n = before.by_pose.size();
    if (n < 2 || after.by_pose.size() != n) return false;
    double mean = 0, square = 0;
    for (std::size_t p = 0; p < n; ++p) mean += (before.by_pose[p] - after.by_pose[p]) / static_cast<double>(n);
    for (std::size_t p = 0; p < n; ++p) square += std::pow(before.by_pose[p] - after.by_pose[p] - mean, 2);
    const double standard_error = std::sqrt(square / static_cast<double>(n * (n - 1)));
    return mean > standard_error;
  }

  /// The family-wise level at which a maximum like `log_p` is reached by chance when whole poses' residuals change
  /// sign: what heavy tails do to the F test. Only the candidate's own columns are tried; the number scanned
  /// multiplies.
  double sign_flip_p(const Projection& base, const Candidate& candidate, double gain) const {
    constexpr int kFlips = 2000;
    const CandidateScore own = score(base, candidate.columns);
    if (own.rank == 0) return 1;
    const Eigen::MatrixXd projected = base.apply(candidate.columns);
    const Eigen::MatrixXd gram = candidate.columns.transpose() * projected;
    const Eigen::MatrixXd inverse = gram.completeOrthogonalDecomposition().pseudoInverse();
    // What the candidate leaves is the noise to flip: contribution of each pose to Z' r, turned as a whole.
    const Eigen::VectorXd left =
        base.residual() - projected * (inverse * (candidate.columns.transpose() * base.residual()));
    Eigen::MatrixXd by_pose =
        Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(problem().poses.size()), candidate.columns.cols());
    for (Eigen::Index i = 0; i < left.size(); ++i)
      by_pose.row(static_cast<Eigen::Index>(problem().readings[static_cast<std::size_t>(i)].pose)) +=
          left[i] * projected.row(i);
    std::uint64_t state = 0x9E3779B97F4A7C15ULL;
    int reached = 0;
    for (int flip = 0; flip < kFlips; ++flip) {
      Eigen::VectorXd sum = Eigen::VectorXd::Zero(candidate.columns.cols());
      for (Eigen::Index p = 0; p < by_pose.rows(); ++p) {
        state ^= state << 13, state ^= state >> 7, state ^= state << 17;
        sum += (state & 1 ? 1.0 : -1.0) * by_pose.row(p).transpose();
      }
      if (sum.dot(inverse * sum) >= gain) ++reached;
    }
    return (reached + 1.0) / (kFlips + 1.0);
  }

  struct Choice {
    Candidate candidate;
    CandidateScore smooth, free;
    bool from_catalogue = true;
    double family_wise = 1;
    bool rigid = false;
  };

  std::optional<Choice> choose() {
    const std::vector<CandidateScore> by_smooth = scores(*smooth_, candidates_);
    const std::vector<CandidateScore> by_free =
        free_ ? scores(*free_, candidates_) : std::vector<CandidateScore>(candidates_.size());
    struct Ranked {
      double evidence;
      std::size_t index;
    };
    std::vector<Ranked> ranked;
    const double n = smooth_->freedom();
    for (std::size_t k = 0; k < candidates_.size(); ++k) {
      const double p = std::min(by_smooth[k].p_value, by_free[k].p_value) * multiplicity();
      if (p > options_.level || is_accepted(*candidates_[k].effect)) continue;
      const CandidateScore& s = by_smooth[k];
      ranked.push_back({s.log_likelihood - 0.5 * s.rank * std::log(n) - 0.5 * shape_size(k) * std::log(n), k});
    }
    std::ranges::sort(ranked, std::greater<>{}, &Ranked::evidence);
    if (ranked.size() > 6) ranked.resize(6);
    std::optional<Choice> best;
    double best_evidence = -std::numeric_limits<double>::infinity();
    for (const Ranked& r : ranked) {
      Candidate candidate = refined(problem(), *smooth_, candidates_[r.index]);
      const CandidateScore s = score(*smooth_, candidate.columns);
      const double evidence = s.log_likelihood - 0.5 * (s.rank + shape_size(r.index)) * std::log(n);
      if (evidence <= best_evidence) continue;
      best_evidence = evidence;
      best = Choice{candidate, s, free_ ? score(*free_, candidate.columns) : CandidateScore{}};
    }
    return best;
  }

  double shape_size(std::size_t k) const { return static_cast<double>(candidates_[k].effect->shape().size()); }

  bool is_accepted(const Effect& effect) const {
    return std::ranges::any_of(accepted_, [&](const Candidate& c) { return c.effect->id() == effect.id(); });
  }

  /// What only the smooth base shows counts only if a richer map does not explain it away.
  bool survives_a_richer_map(Choice& choice) const {
    HarmonicBasis richer = basis_;
    richer.tilt_degree = basis_.tilt_degree + 3;
    richer.harmonics = basis_.harmonics + 2;
    richer.turn_degree = basis_.turn_degree + 2 > 4 ? 4 : basis_.turn_degree + 2;
    const SmoothOptions o = smooth_options(searched(), accepted_extras());
    const SmoothPrior prior = fit_smooth(problem(), richer, o).prior;
    const SmoothProjection base(projection_input(searched(), accepted_extras()), richer, prior);
    const CandidateScore s = score(base, choice.candidate.columns);
    choice.family_wise = std::max(choice.smooth.p_value, s.p_value) * multiplicity();
    return choice.family_wise < options_.level;
  }

  bool step() {
    std::optional<Choice> choice = choose();
    const double chi2_p = chi_square_tail(smooth_->residual_square(), smooth_->freedom());
    const double free_chi2_p = free_ ? chi_square_tail(free_->residual_square(), free_->freedom()) : 1.0;
    const bool chi2_fails = std::min(chi2_p, free_chi2_p) < options_.smooth_level;
    if (chi2_fails) consider_fallback(choice);
    if (!choice) return false;
    const std::string id = choice->candidate.effect->id();
    if (!choice->from_catalogue) return accept_or_drop(*choice);
    choice->family_wise = std::min(choice->free.p_value, choice->smooth.p_value) * multiplicity();
    choice->rigid = !(choice->free.p_value * multiplicity() < options_.level);
    if (choice->rigid && !survives_a_richer_map(*choice)) {
      result_.refused.push_back(id + ": a richer map of the rotary errors explains it as well");
      return drop(id);
    }
    if (!choice->rigid) choice->family_wise = choice->free.p_value * multiplicity();
    const Projection& judge =
        choice->rigid ? static_cast<const Projection&>(*smooth_) : static_cast<const Projection&>(*free_);
    const double flip_p =
        !choice->from_catalogue
            ? 0
            : sign_flip_p(judge, choice->candidate, choice->rigid ? choice->smooth.gain : choice->free.gain);
    if (flip_p > 0.01) {
      result_.refused.push_back(id + ": poses with their residuals' signs changed show as much");
      return drop(id);
    }
    return accept_or_drop(*choice);
  }

  /// The gates that every kind of effect must pass; true while the search is to go on.
  bool accept_or_drop(const Choice& chosen) {
    const Choice* choice = &chosen;
    const std::string id = chosen.candidate.effect->id();
    const Extras before_columns = accepted_extras(), after_columns = extended(choice->candidate);
    const HoldoutError before = holdout_error(before_columns), after = holdout_error(after_columns);
    if (!falls(before, after)) {
      result_.refused.push_back(id + ": the error at poses kept back does not fall");
      if (!chosen.from_catalogue) {
        fallback_closed_ = true;
        return true;
      }
      return drop(id);
    }
    AcceptedEffect found{.effect = choice->candidate.effect,
                         .smooth = !choice->from_catalogue,
                         .p_value = std::min(1.0, choice->family_wise)};
    found.visible_fraction = free_ && !choice->rigid ? choice->free.visible_fraction : choice->smooth.visible_fraction;
    found.rigid_within_poses = choice->rigid;
    found.rms_before_um = stage_rms(before_columns);
    found.rms_after_um = stage_rms(after_columns);
    found.holdout_before_um = before.rms_um;
    found.holdout_after_um = after.rms_um;
    describe_confounding(found, choice->candidate);
    accepted_.push_back(choice->candidate);
    result_.effects.push_back(std::move(found));
    find_chips();  // readings that looked far off may have been the effect's
    fit_base();
    return true;
  }

  /// Takes an effect that failed a gate off the list; the search goes on with the others.
  bool drop(const std::string& id) {
    std::erase_if(candidates_, [&](const Candidate& c) { return c.effect->id() == id; });
    ++dropped_;
    return dropped_ < 6;
  }

  /// Whether chi-square would pass with `choice` added.
  bool would_explain(const Choice& choice) const {
    const auto passes = [&](const Projection& base, const CandidateScore& s) {
      return chi_square_tail(base.residual_square() - s.gain, base.freedom() - s.rank) >= options_.smooth_level;
    };
    return passes(*smooth_, choice.smooth) && (!free_ || passes(*free_, choice.free));
  }

  /// The smooth fallback opens where the catalogue has nothing, or where an entry does not bring chi-square down and a
  /// smooth effect of the same quantity is likelier by more than 3.
  void consider_fallback(std::optional<Choice>& choice) {
    if (fallback_closed_ || (choice && would_explain(*choice))) return;
    const std::optional<SmoothCandidate> found =
        best_smooth_candidate(problem(), *smooth_, scope_, options_.smooth_level);
    if (!found) return;
    Choice fallback{found->candidate, score(*smooth_, found->candidate.columns),
                    free_ ? score(*free_, found->candidate.columns) : CandidateScore{}, false};
    if (choice) {
      const std::vector<std::string> named = choice->candidate.effect->depends_on(),
                                     own = found->candidate.effect->depends_on();
      const bool same_quantity = own.size() == 1 && std::ranges::find(named, own.front()) != named.end();
      const double evidence = choice->smooth.log_likelihood - 0.5 * choice->smooth.rank * std::log(smooth_->freedom());
      if (!same_quantity || found->log_likelihood < evidence + 3) return;
    }
    fallback.family_wise = found->p_value;
    choice = std::move(fallback);
  }

  double stage_rms(const Extras& columns) const {
    SmoothOptions o = smooth_options(used_, columns);
    o.prior = prior_;
    const SmoothFit fit = fit_smooth(problem(), basis_, o);
    return whitened_rms_um(problem(), fit.residual, used_);
  }

  void describe_confounding(AcceptedEffect& found, const Candidate& chosen) const {
    const Projection& base = found.rigid_within_poses || !free_ ? static_cast<const Projection&>(*smooth_) : *free_;
    std::set<std::string> strong, partly;
    const std::vector<double> correlations = canonical_correlations(base, chosen, candidates_);
    for (std::size_t k = 0; k < candidates_.size(); ++k) {
      const std::string id = candidates_[k].effect->id();
      if (id == chosen.effect->id()) continue;
      if (correlations[k] > kNotSeparable)
        strong.insert(id);
      else if (correlations[k] > kPartlySeparable)
        partly.insert(id);
    }
    for (const std::string& id : strong) partly.erase(id);
    found.not_separable_from.assign(strong.begin(), strong.end());
    found.partly_separable_from.assign(partly.begin(), partly.end());
    if (!strong.empty()) found.separate_by = family_of(found.smooth ? *strong.begin() : found.effect->id()).remedy;
    if (found.rigid_within_poses && found.separate_by.empty() && !found.smooth)
      found.separate_by = std::string(family_of(found.effect->id()).remedy);
  }

  /// An effect that the later ones made needless goes again.
  void check_backward() {
    for (std::size_t k = accepted_.size(); k-- > 0 && accepted_.size() > 1;) {
      const ProjectionInput input = projection_input(searched(), accepted_extras(k));
      const SmoothProjection smooth(input, basis_, prior_);
      double p = score(smooth, accepted_[k].columns).p_value;
      if (free_) p = std::min(p, score(FreePoseProjection(input), accepted_[k].columns).p_value);
      if (p * multiplicity() < options_.level) continue;
      result_.refused.push_back(accepted_[k].effect->id() + ": no longer needed beside the others");
      accepted_.erase(accepted_.begin() + static_cast<std::ptrdiff_t>(k));
      result_.effects.erase(result_.effects.begin() + static_cast<std::ptrdiff_t>(k));
    }
  }

  void finish() {
    // Shapes once more, on all data.
    if (!accepted_.empty()) {
      for (std::size_t k = 0; k < accepted_.size(); ++k) {
        if (result_.effects[k].smooth) continue;
        const SmoothProjection base(projection_input(used_, accepted_extras(k)), basis_, prior_);
        accepted_[k] = refined(problem(), base, accepted_[k]);
      }
      find_chips();
    }
    const Extras columns = accepted_extras(), nothing = no_extras();
    SmoothOptions with = smooth_options(used_, columns);
    const SmoothFit after = fit_smooth(problem(), basis_, with);
    prior_ = after.prior;
    SmoothOptions without = smooth_options(used_, nothing);
    const SmoothFit before = fit_smooth(problem(), basis_, without);
    result_.residual_before = before.residual;
    result_.residual_after = after.residual;
    for (std::size_t i = 0; i < used_.size(); ++i)
      if (!used_[i]) result_.outliers.push_back(i);
    const auto stage = [&](const SmoothFit& fit, const Extras& effects) {
      ClosureStage s;
      s.rms_um = whitened_rms_um(problem(), fit.residual, used_);
      const SmoothProjection base(projection_input(used_, effects), basis_, fit.prior);
      s.reduced_chi2 = base.residual_square() / base.freedom();
      s.chi2_p = chi_square_tail(base.residual_square(), base.freedom());
      if (!problem().has_pose_kind) {
        const FreePoseProjection free(projection_input(used_, effects));
        if (free.freedom() > 0)
          s.chi2_p = std::min(1.0, 2 * std::min(s.chi2_p, chi_square_tail(free.residual_square(), free.freedom())));
      }
      s.holdout_rms_um = holdout_error(effects).rms_um;
      return s;
    };
    result_.before = stage(before, nothing);
    result_.after = stage(after, columns);
    if (accepted_.empty())
      result_.verdict = result_.before.chi2_p >= 0.001 ? Verdict::nothing_missing : Verdict::unexplained;
    else
      result_.verdict = result_.after.chi2_p >= 0.001 ? Verdict::explained : Verdict::partly_explained;
    build_model(after);
    list_untestable();
  }

  void build_model(const SmoothFit& fit) {
    result_.model.machine = {machine_.name, machine_.serial, machine_.structure.code};
    RotaryMapContent content = map_from_surface(problem(), find_grid(problem().poses), fit);
    set_smooth_surface(content, problem(), fit);
    result_.model.effects.push_back(std::make_shared<RotaryErrorMap>(std::move(content), effect_context(machine_)));
    Eigen::Index at = 0;
    for (std::size_t k = 0; k < accepted_.size(); ++k) {
      const auto m = static_cast<Eigen::Index>(accepted_[k].effect->parameters().size());
      const Eigen::VectorXd& unit = accepted_[k].scale;
      const Eigen::VectorXd values = fit.extra.segment(at, m).cwiseProduct(unit);
      const Eigen::MatrixXd covariance =
          unit.asDiagonal() * fit.extra_covariance.block(at, at, m, m) * unit.asDiagonal();
      const EffectPtr final_effect = accepted_[k].effect->with_parameters(values, covariance);
      result_.effects[k].effect = final_effect;
      if (!result_.effects[k].smooth) {
        const double bound = family_of(final_effect->id()).absurd;
        for (const Parameter& p : final_effect->parameters())
          result_.effects[k].absurd = result_.effects[k].absurd || (bound > 0 && std::abs(p.value) > bound);
      }
      result_.model.effects.push_back(final_effect);
      at += m;
    }
  }

  void list_untestable() {
    std::set<std::string> seen;
    const std::vector<CandidateScore> by_smooth = scores(*smooth_, candidates_);
    for (std::size_t k = 0; k < candidates_.size(); ++k) {
      const std::string id = candidates_[k].effect->id();
      if (is_accepted(*candidates_[k].effect) || by_smooth[k].rank > 0) seen.insert(id);
    }
    for (const Candidate& c : candidates_)
      if (seen.insert(c.effect->id()).second)
        result_.untestable.push_back({c.effect->id(), std::string(family_of(c.effect->id()).remedy)});
  }

  ClosureOptions options_;
  const Machine& machine_;
  ClosureResult result_;
  Split split_;
  HarmonicBasis basis_;
  SmoothPrior prior_;
  Eigen::VectorXd y_;
  std::vector<bool> used_;
  CandidateScope scope_;
  std::vector<Candidate> candidates_, accepted_;
  std::unique_ptr<FreePoseProjection> free_;
  std::unique_ptr<SmoothProjection> smooth_;
  int dropped_ = 0;
  bool fallback_closed_ = false;
};

}  // namespace

std::string_view verdict_text(Verdict verdict) {
  switch (verdict) {
    case Verdict::nothing_missing:
      return "nothing missing";
    case Verdict::explained:
      return "explained";
    case Verdict::partly_explained:
      return "partly explained";
    case Verdict::unexplained:
      return "unexplained";
  }
  return {};
}

ClosureResult close_loop(const ObservationSet& all, std::size_t verification_from, const Machine& machine,
                         const ClosureOptions& options) {
  return Search(all, verification_from, machine, options).run();
}

}  // namespace trunnion
