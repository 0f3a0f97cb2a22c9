#include "discovery/closure.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <set>

#include "discovery/closure_result.h"
#include "discovery/richer_map.h"
#include "discovery/smooth_candidates.h"

namespace trunnion {
namespace {

constexpr int kMostEnlargements = 3, kMostRefusals = 6, kMostRefits = 2;
constexpr std::size_t kRefined = 5;        // candidates whose shapes are moved to their summits before one is chosen
constexpr double kNearby = 1e4;            // times the level: worth a second look with shape and map at their best
constexpr double kRicherMapGain = 5;       // log likelihood that an enlargement of the map must bring
constexpr double kFallbackPreference = 3;  // log likelihood by which a smooth effect must beat a named one
constexpr double kBeyondDoubt = 8;         // the same where chi-square does not speak for it: that test is a blunt one
constexpr double kAlike = 0.5;             // correlation with a refused candidate at which others share its fate

/// Families that are the base itself, or what is left where the catalogue ends.
bool is_base(std::string_view family) {
  return family == "rotary_error_map" || family == "location_errors" || family == "smooth";
}

CandidateScope scope_of(const ObservationSet& all, const LinearProblem& problem, const Machine& machine) {
  CandidateScope scope{.context = effect_context(machine), .readings = problem.situations};
  if (all.has_time) scope.columns.push_back("time_s");
  if (all.has_temperature) scope.columns.push_back("temperature_C");
  if (all.has_tilt_sense) scope.columns.push_back(std::string(1, machine.tilt_letter()) + "_dir");
  if (all.has_turn_sense) scope.columns.push_back("C_dir");
  if (all.has_repeat) scope.columns.push_back("repeat");
  scope.columns.insert(scope.columns.end(), all.extra_columns.begin(), all.extra_columns.end());
  for (const std::string& artifact : all.artifacts)
    if (!artifact.empty()) scope.artifacts.push_back(artifact);
  return scope;
}

/// What is to be added next, with its evidence.
struct Choice {
  Candidate candidate;
  CandidateScore smooth, free;
  double log_likelihood = 0;
  bool from_catalogue = true;
  bool rigid = false;  ///< only the smooth base shows it
  double family_wise = 1;
};

class Search {
 public:
  Search(const ObservationSet& all, std::size_t verification_from, const Machine& machine,
         const ClosureOptions& options)
      : options_(options),
        machine_(machine),
        bench_(all, verification_from, machine, options.folds),
        scope_(scope_of(all, bench_.problem(), machine)) {
    collect_candidates();
  }

  ClosureResult run() {
    double sum = 0;
    for (const Reading& reading : bench_.problem().readings)
      sum += std::pow(reading.sigma * (reading.angular ? 1e5 : 1e3), 2);
    result_.noise_um = std::sqrt(sum / static_cast<double>(bench_.problem().readings.size()));
    tell("readings far off");
    bench_.find_chips();
    refit();
    while (static_cast<int>(bench_.accepted.size()) < options_.most_effects) {
      tell("effect " + std::to_string(bench_.accepted.size() + 1) + " of at most " +
           std::to_string(options_.most_effects) + " among " + std::to_string(screen_.column_count()) + " columns");
      if (!step()) break;
    }
    tell("what was found, looked at together");
    check_backward();
    settle_shapes();
    tell("verdict and what data cannot tell apart");
    conclude(result_, bench_, screen_, machine_, options_);
    return std::move(result_);
  }

 private:
  void tell(const std::string& step) const {
    if (options_.progress) options_.progress(step);
  }

  void collect_candidates() {
    std::vector<Candidate> found;
    for (const Family& family : catalogue()) {
      const std::vector<EffectPtr> effects = family.candidates(scope_);
      if (effects.empty() && !is_base(family.name))
        result_.untestable.push_back({std::string(family.name), std::string(family.remedy)});
      for (const EffectPtr& effect : effects) {
        found.push_back(make_candidate(bench_.problem(), effect));
        found.back().members = static_cast<double>(effects.size());
      }
    }
    screen_ = Screen(std::move(found));
    refused_.assign(screen_.candidates().size(), false);
    result_.columns_scanned = screen_.column_count();
  }

  void refit() {
    bench_.refit(bench_.searched());
    by_smooth_ = screen_.view(bench_.smooth(), bench_.design().columns.cols(), bench_.map_version());
    by_free_ = bench_.free() != nullptr ? screen_.view(*bench_.free()) : Screen::View{};
  }

  double multiplicity() const { return 2 * static_cast<double>(std::max<std::size_t>(1, screen_.column_count())); }

  bool is_accepted(const Effect& effect) const {
    return std::ranges::any_of(bench_.accepted, [&](const Candidate& c) { return c.effect->id() == effect.id(); });
  }

  bool chi2_fails() const { return bench_.chi2_p() < options_.smooth_level; }
  /// Whether chi-square passes with `choice` added.
  bool explains(const Choice& choice) const {
    return bench_.chi2_p(choice.smooth, choice.free) >= options_.smooth_level;
  }

  /// The likeliest candidate of the catalogue among those that pass the F test over all columns scanned.
  std::optional<Choice> named_choice() const {
    struct Ranked {
      double log_likelihood;
      std::size_t index;
    };
    std::vector<Ranked> ranked;
    for (std::size_t k = 0; k < screen_.candidates().size(); ++k) {
      const Candidate& c = screen_.candidates()[k];
      const CandidateScore& s = by_smooth_.scores[k];
      const double p = std::min(s.p_value, by_free_.base != nullptr ? by_free_.scores[k].p_value : 1.0);
      if (refused_[k] || s.rank == 0 || p * multiplicity() > options_.level * kNearby || is_accepted(*c.effect))
        continue;
      ranked.push_back({evidence(s, bench_.smooth(), c.members), k});
    }
    std::ranges::sort(ranked, std::greater<>{}, &Ranked::log_likelihood);
    if (ranked.size() > kRefined) ranked.resize(kRefined);
    std::optional<Choice> best;
    int refits = 0;
    for (const Ranked& r : ranked) {
      Choice choice{.candidate = refined(bench_.problem(), bench_.smooth(), screen_.candidates()[r.index])};
      judge(choice);
      if (choice.family_wise > options_.level && !best && refits++ < kMostRefits) judge_with_the_map_refitted(choice);
      if (choice.family_wise > options_.level) continue;
      if (!best || choice.log_likelihood > best->log_likelihood) best = std::move(choice);
    }
    return best;
  }

  void judge(Choice& choice) const {
    choice.smooth = score(bench_.smooth(), choice.candidate.columns);
    if (bench_.free() != nullptr) choice.free = score(*bench_.free(), choice.candidate.columns);
    weigh(choice, bench_.smooth());
  }

  void weigh(Choice& choice, const Projection& base) const {
    choice.log_likelihood = evidence(choice.smooth, base, choice.candidate.members);
    choice.rigid = choice.free.p_value * multiplicity() > options_.level;
    choice.family_wise = std::min(1.0, (choice.rigid ? choice.smooth : choice.free).p_value * multiplicity());
  }

  /// A map that had to do without the effect may have taken much of it over: its prior once more, with the effect.
  void judge_with_the_map_refitted(Choice& choice) const {
    const std::vector<bool> rows = bench_.searched();
    const EffectColumns now = bench_.accepted_columns();
    const SmoothPrior prior = bench_.fit(bench_.basis(), rows, with_one_more(now, choice.candidate), {}).prior;
    const SmoothDesign design{bench_.design().columns, smooth_precision(bench_.problem(), bench_.basis(), prior)};
    const SmoothProjection base(bench_.input(rows, now), design);
    const CandidateScore refitted = score(base, choice.candidate.columns);
    if (refitted.p_value >= choice.smooth.p_value) return;
    choice.smooth = refitted;
    weigh(choice, base);
  }

  /// One effect more, or a richer map, or one candidate less; false where the search is over.
  bool step() {
    std::optional<Choice> choice = named_choice();
    keep_touches_if_likelier(choice);
    if (enlarge_map(choice)) return true;
    consider_fallback(choice);
    if (choice && !choice->from_catalogue && enlarge_map(choice)) return true;
    if (!choice) return false;
    if (choice->from_catalogue && turned_signs_show_as_much(*choice))
      return refuse(*choice, "poses with their residuals' signs changed show as much");
    return accept_or_refuse(*choice);
  }

  /// Touches that look like chips may be the work of an effect: it keeps them if that is likelier, each touch removed
  /// being charged 2 log N.
  void keep_touches_if_likelier(std::optional<Choice>& choice) {
    const std::vector<bool> sparse = bench_.used();
    const auto removed = static_cast<double>(std::ranges::count(bench_.searched(), false) -
                                             std::ranges::count(bench_.split().search, false));
    if (removed == 0) return;
    const auto total = [&](const std::optional<Choice>& c) {
      return -0.5 * bench_.smooth().residual_square() + (c ? c->log_likelihood : 0);
    };
    const double without = total(choice) - 2 * std::log(static_cast<double>(sparse.size())) * removed;
    bench_.set_used(std::vector<bool>(sparse.size(), true));
    refit();
    std::optional<Choice> with_all = named_choice();
    if (with_all && total(with_all) > without) {
      // What still stands out beside the effect is a chip.
      bench_.accepted.push_back(with_all->candidate);
      bench_.find_chips();
      bench_.accepted.pop_back();
      refit();
      judge(*with_all);
      choice = std::move(with_all);
      return;
    }
    bench_.set_used(sparse);
    refit();
  }

  /// The rotary maps get more freedom where that explains the readings better than anything named does.
  bool enlarge_map(const std::optional<Choice>& choice) {
    if (enlargements_ == kMostEnlargements || !(chi2_fails() || (choice && choice->rigid))) return false;
    const RicherMap richer = best_richer_map(bench_);
    if (richer.gain < kRicherMapGain || (choice && choice->log_likelihood > richer.gain)) return false;
    bench_.set_basis(richer.basis);
    refit();
    ++enlargements_;
    return true;
  }

  bool turned_signs_show_as_much(const Choice& choice) const {
    const Screen::View& view = choice.rigid ? by_smooth_ : by_free_;
    const CandidateScore& s = choice.rigid ? choice.smooth : choice.free;
    return screen_.sign_flip_level(bench_.problem(), view, choice.candidate, s.gain, s.rank, options_.level) >
           options_.flip_level;
  }

  /// The smooth fallback opens where the catalogue has nothing and chi-square fails, where a smooth effect brings
  /// chi-square down, a named one does not, and it is clearly likelier, and where it is likelier beyond doubt.
  void consider_fallback(std::optional<Choice>& choice) {
    if (fallback_closed_) return;
    const std::optional<SmoothCandidate> found =
        best_smooth_candidate(bench_.problem(), bench_.smooth(), scope_, on_measurement(), options_.smooth_level);
    if (!found) return;
    Choice fallback{.candidate = found->candidate};
    judge(fallback);
    fallback.from_catalogue = false;
    fallback.log_likelihood = found->log_likelihood;
    fallback.family_wise = found->p_value;
    const double ahead = fallback.log_likelihood - (choice ? choice->log_likelihood : 0);
    const bool wanted =
        chi2_fails() && (!choice || (ahead > kFallbackPreference && !explains(*choice) && explains(fallback)));
    if (wanted || ahead > kBeyondDoubt) choice = std::move(fallback);
  }

  /// Columns of the data by which an accepted smooth effect acts on the measurement. Where the machine stands is none:
  /// what depends on that is the machine's unless its direction says otherwise.
  std::vector<std::string> on_measurement() const {
    std::vector<std::string> columns;
    for (const AcceptedEffect& e : result_.effects)
      if (e.smooth && e.effect->origin() == Origin::measurement)
        for (const std::string& column : e.effect->depends_on())
          if (std::ranges::find(scope_.columns, column) != scope_.columns.end()) columns.push_back(column);
    return columns;
  }

  /// The poses kept back decide: their error is looked at once, after the choice. Where they would hardly feel the
  /// effect, the other poses decide, left out in turn, and those kept back must not say otherwise.
  bool accept_or_refuse(const Choice& choice) {
    const EffectColumns now = bench_.accepted_columns(), then = with_one_more(now, choice.candidate);
    Fall decisive = fall(bench_.holdout(now), bench_.holdout(then));
    const bool contradicted = decisive.contradicts();
    if (bench_.split().has_holdout() && decisive.silent()) decisive = fall(bench_.folds(now), bench_.folds(then));
    if (contradicted || !decisive.clear()) return refuse(choice, "the error at poses kept back does not fall");
    AcceptedEffect found{.effect = choice.candidate.effect,
                         .smooth = !choice.from_catalogue,
                         .p_value = choice.family_wise,
                         .visible_fraction = (choice.rigid ? choice.smooth : choice.free).visible_fraction,
                         .rigid_within_poses = choice.rigid};
    bench_.accepted.push_back(choice.candidate);
    result_.effects.push_back(std::move(found));
    bench_.find_chips();  // readings that looked far off may have been the effect's
    refit();
    return true;
  }

  /// Takes a candidate that failed a gate off the list, and those that do nearly the same; the search goes on.
  bool refuse(const Choice& choice, const std::string& why) {
    result_.refused.push_back(choice.candidate.effect->id() + ": " + why);
    if (!choice.from_catalogue) {
      fallback_closed_ = true;
      return true;
    }
    const std::vector<double> alike =
        screen_.correlations(choice.rigid ? by_smooth_ : by_free_, choice.candidate.columns);
    for (std::size_t k = 0; k < refused_.size(); ++k)
      refused_[k] =
          refused_[k] || alike[k] > kAlike || screen_.candidates()[k].effect->id() == choice.candidate.effect->id();
    return ++refusals_ < kMostRefusals;
  }

  /// An effect that the later ones made needless goes again.
  void check_backward() {
    for (std::size_t k = bench_.accepted.size(); k-- > 0 && bench_.accepted.size() > 1;) {
      const ProjectionInput input = bench_.input(bench_.searched(), bench_.accepted_columns(k));
      double p = score(SmoothProjection(input, bench_.design()), bench_.accepted[k].columns).p_value;
      if (bench_.free() != nullptr)
        p = std::min(p, score(FreePoseProjection(input), bench_.accepted[k].columns).p_value);
      if (p * multiplicity() < options_.level) continue;
      result_.refused.push_back(bench_.accepted[k].effect->id() + ": no longer needed beside the others");
      bench_.accepted.erase(bench_.accepted.begin() + static_cast<std::ptrdiff_t>(k));
      result_.effects.erase(result_.effects.begin() + static_cast<std::ptrdiff_t>(k));
    }
  }

  /// Shapes are scanned and refined again on all readings: what was left out of the search may lie beyond a moment.
  void settle_shapes() {
    bool changed = false;
    for (std::size_t k = 0; k < bench_.accepted.size(); ++k) {
      Candidate& settled = bench_.accepted[k];
      if (result_.effects[k].smooth || settled.effect->shape().empty()) continue;
      const std::vector<bool> everything(bench_.used().size(), true);
      const SmoothProjection base(bench_.input(everything, bench_.accepted_columns(k)), bench_.design());
      double most = score(base, settled.columns).gain;
      for (const Candidate& c : screen_.candidates()) {
        if (c.effect->id() != settled.effect->id()) continue;
        if (const double gain = score(base, c.columns).gain; gain > most) most = gain, settled = c;
      }
      settled = refined(bench_.problem(), base, settled);
      changed = true;
    }
    if (changed) bench_.find_chips();
  }

  ClosureOptions options_;
  const Machine& machine_;
  ClosureResult result_;
  Workbench bench_;
  CandidateScope scope_;
  Screen screen_;
  Screen::View by_smooth_, by_free_;
  std::vector<bool> refused_;  ///< per candidate of the screen
  int refusals_ = 0, enlargements_ = 0;
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

namespace {

/// One row of each run of `stride`, drawn at random, so that no period of the log is in step with the choice.
ObservationSet one_of_each(const ObservationSet& all, std::size_t stride, std::size_t& verification_from) {
  ObservationSet some = all;
  some.rows.clear(), some.file_of_row.clear(), some.extra_values.clear();
  std::mt19937_64 random(stride);
  const std::size_t columns = all.extra_columns.size();
  std::size_t before = 0;
  for (std::size_t first = 0; first < all.rows.size(); first += stride) {
    const std::size_t row = first + random() % std::min(stride, all.rows.size() - first);
    if (row < verification_from) ++before;
    some.rows.push_back(all.rows[row]);
    if (!all.file_of_row.empty()) some.file_of_row.push_back(all.file_of_row[row]);
    const auto values = all.extra_values.begin() + static_cast<std::ptrdiff_t>(row * columns);
    some.extra_values.insert(some.extra_values.end(), values, values + static_cast<std::ptrdiff_t>(columns));
  }
  verification_from = verification_from >= all.rows.size() ? some.rows.size() : before;
  return some;
}

}  // namespace

ClosureResult close_loop(const ObservationSet& all, std::size_t verification_from, const Machine& machine,
                         const ClosureOptions& options) {
  if (all.rows.size() <= 2 * options.most_readings) return Search(all, verification_from, machine, options).run();
  const std::size_t stride = (all.rows.size() + options.most_readings - 1) / options.most_readings;
  const auto some = std::make_shared<const ObservationSet>(one_of_each(all, stride, verification_from));
  ClosureResult result = Search(*some, verification_from, machine, options).run();
  result.thinned = some;
  return result;
}

}  // namespace trunnion
