#include "discovery/closure_result.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "discovery/process_gain.h"
#include "identification/distributions.h"
#include "identification/map_grid.h"
#include "model/effects/rotary_error_map.h"

namespace trunnion {
namespace {

constexpr double kNotSeparable = 0.95, kPartlySeparable = 0.5;
constexpr double kAsLikely = 2;        // log units
constexpr double kWorthRefining = 10;  // log units behind, at most

ClosureStage stage(const Workbench& bench, const EffectColumns& effects) {
  ClosureStage s{.rms_um = bench.rms_um(bench.used(), effects)};
  const ProjectionInput input = bench.input(bench.used(), effects);
  const SmoothProjection base(input, bench.design());
  s.reduced_chi2 = base.residual_square() / base.freedom();
  s.chi2_p = chi_square_tail(base.residual_square(), base.freedom());
  if (bench.free() != nullptr) {
    const FreePoseProjection free(input);
    if (free.freedom() > 0)
      s.chi2_p = std::min(1.0, 2 * std::min(s.chi2_p, chi_square_tail(free.residual_square(), free.freedom())));
  }
  return s;
}

Model model_of(const LinearProblem& problem, const SmoothFit& fit, const Machine& machine) {
  Model model;
  model.machine = {machine.name, machine.serial, machine.structure.code};
  RotaryMapContent content = map_from_surface(problem, find_grid(problem.poses), fit);
  set_smooth_surface(content, problem, fit);
  model.effects.push_back(std::make_shared<RotaryErrorMap>(std::move(content), effect_context(machine)));
  return model;
}

void fill_values(ClosureResult& result, const Workbench& bench, const SmoothFit& fit) {
  Eigen::Index at = 0;
  for (std::size_t k = 0; k < bench.accepted.size(); ++k) {
    const Candidate& candidate = bench.accepted[k];
    AcceptedEffect& found = result.effects[k];
    const Eigen::Index m = candidate.columns.cols();
    const Eigen::VectorXd& unit = candidate.scale;
    const Eigen::VectorXd whitened = fit.extra.segment(at, m);
    found.effect = candidate.effect->with_parameters(
        whitened.cwiseProduct(unit), unit.asDiagonal() * fit.extra_covariance.block(at, at, m, m) * unit.asDiagonal());
    at += m;
    const Eigen::VectorXd done = candidate.columns * whitened;
    for (std::size_t i = 0; i < bench.problem().readings.size(); ++i) {
      const Reading& reading = bench.problem().readings[i];
      const double um = done[static_cast<Eigen::Index>(i)] * reading.sigma * (reading.angular ? 1e5 : 1e3);
      found.largest_um = std::max(found.largest_um, std::abs(um));
    }
    for (const std::string& column : found.effect->depends_on()) {
      static const std::set<std::string> in_a_program = {"A_deg", "B_deg", "C_deg", "A_dir", "B_dir", "C_dir",
                                                         "x_mm",  "y_mm",  "z_mm",  "xw_mm", "yw_mm", "zw_mm"};
      if (found.effect->origin() == Origin::machine && !in_a_program.contains(column)) found.needs.push_back(column);
    }
    if (!found.smooth) {
      const double bound = family_of(found.effect->id()).absurd;
      for (const Parameter& p : found.effect->parameters()) {
        const double limit = p.absurd > 0 ? p.absurd : bound;
        found.absurd = found.absurd || (limit > 0 && std::abs(p.value) > limit);
      }
    }
    result.model.effects.push_back(found.effect);
  }
}

/// What else of the catalogue does nearly the same as the fitted effect number `k`, and how likely it is.
std::vector<Alternative> alternatives(const Workbench& bench, Screen& screen, const SmoothProjection& base,
                                      std::size_t k, const Effect& fitted, double log_likelihood) {
  const Candidate& chosen = bench.accepted[k];
  const Eigen::VectorXd signal = chosen.columns * fitted.values().cwiseQuotient(chosen.scale);
  const Eigen::VectorXd projected = base.apply(signal);
  const double size = std::sqrt(std::max(1e-300, signal.dot(projected)));
  const Screen::View view = screen.view(base, bench.design().columns.cols(), bench.map_version());
  std::map<std::string, Alternative> best;
  for (std::size_t j = 0; j < screen.candidates().size(); ++j) {
    const Candidate& other = screen.candidates()[j];
    const std::string id = other.effect->id();
    if (id == fitted.id() || view.scores[j].rank == 0 ||
        std::ranges::any_of(bench.accepted, [&](const Candidate& c) { return c.effect->id() == id; }))
      continue;
    const double correlation =
        (view.spaces[j].whitening.transpose() * (other.columns.transpose() * projected)).norm() / size;
    if (correlation < kPartlySeparable) continue;
    double behind = log_likelihood - evidence(view.scores[j], base, other.members);
    if (behind < kWorthRefining && !other.effect->shape().empty())
      behind =
          log_likelihood - evidence(score(base, refined(bench.problem(), base, other).columns), base, other.members);
    const auto [at, added] =
        best.try_emplace(id, Alternative{id, other.effect->origin(), std::min(1.0, correlation), behind});
    if (added) continue;
    at->second.correlation = std::max(at->second.correlation, std::min(1.0, correlation));
    at->second.log_likelihood = std::min(at->second.log_likelihood, behind);
  }
  std::vector<Alternative> all;
  for (auto& [id, a] : best) all.push_back(std::move(a));
  std::ranges::stable_sort(all, {}, &Alternative::log_likelihood);
  return all;
}

void describe_confounding(AcceptedEffect& found, const Workbench& bench, Screen& screen, std::size_t k) {
  const Candidate& chosen = bench.accepted[k];
  const ProjectionInput input = bench.input(bench.used(), bench.accepted_columns(k));
  const SmoothProjection smooth(input, bench.design());
  const double log_likelihood = found.smooth ? best_process_gain(smooth, chosen.columns).gain - std::log(chosen.members)
                                             : evidence(score(smooth, chosen.columns), smooth, chosen.members);
  found.alternatives = alternatives(bench, screen, smooth, k, *found.effect, log_likelihood);
  for (const Alternative& a : found.alternatives)
    (a.correlation > kNotSeparable || a.log_likelihood < kAsLikely ? found.not_separable_from
                                                                   : found.partly_separable_from)
        .push_back(a.id);
  if (!found.not_separable_from.empty())
    found.separate_by = family_of(found.smooth ? found.not_separable_from.front() : found.effect->id()).remedy;
  else if (found.rigid_within_poses && !found.smooth)
    found.separate_by = std::string(family_of(found.effect->id()).remedy);
}

/// An effect of the machine is set aside where one of the measurement explains the readings as well: to compensate what
/// the machine does not do would double it.
void suspend_if_undecided(ClosureResult& result, std::size_t k) {
  AcceptedEffect& found = result.effects[k];
  if (found.effect->origin() != Origin::machine) return;
  const bool undecided = std::ranges::any_of(found.alternatives, [](const Alternative& a) {
    return a.origin == Origin::measurement && a.log_likelihood < kAsLikely;
  });
  if (undecided) found.effect = result.model.effects[k + 1] = found.effect->suspended();  // the map comes first
}

void list_untestable(ClosureResult& result, const Workbench& bench, Screen& screen) {
  const SmoothProjection bare(bench.input(bench.used(), side_by_side({}, bench.size())), bench.design());
  const Screen::View view = screen.view(bare, bench.design().columns.cols(), bench.map_version());
  std::set<std::string> testable, listed;
  for (std::size_t k = 0; k < screen.candidates().size(); ++k)
    if (view.scores[k].rank > 0) testable.insert(screen.candidates()[k].effect->id());
  for (const Candidate& c : screen.candidates()) {
    const std::string id = c.effect->id();
    if (!testable.contains(id) && listed.insert(id).second)
      result.untestable.push_back({id, std::string(family_of(id).remedy)});
  }
}

}  // namespace

void conclude(ClosureResult& result, Workbench& bench, Screen& screen, const Machine& machine,
              const ClosureOptions& options) {
  // One effect more at a time, in the order in which they were accepted; the map has the prior that suits it best with
  // those effects, so that none is credited with what the map could have explained.
  const std::vector<Candidate> all = std::exchange(bench.accepted, {});
  SmoothFit before;
  for (std::size_t k = 0;; ++k) {
    const EffectColumns effects = bench.accepted_columns();
    bench.refit(bench.searched());
    const HoldoutError held = bench.holdout(effects);
    bench.refit(bench.used());
    ClosureStage now = stage(bench, effects);
    now.holdout_rms_um = held.rms_um, now.holdout_plain_rms_um = held.plain_rms_um;
    if (k == 0) {
      result.before = now;
      before = bench.fit(bench.basis(), bench.used(), effects, bench.prior());
    } else {
      AcceptedEffect& found = result.effects[k - 1];
      found.rms_before_um = result.after.rms_um, found.rms_after_um = now.rms_um;
      found.holdout_before_um = result.after.holdout_rms_um, found.holdout_after_um = now.holdout_rms_um;
    }
    result.after = now;
    if (k == all.size()) break;
    bench.accepted.push_back(all[k]);
  }
  const bool nothing_added = bench.accepted.empty();
  const bool passes = result.after.chi2_p >= options.smooth_level;
  if (nothing_added)
    result.verdict = passes ? Verdict::nothing_missing : Verdict::unexplained;
  else
    result.verdict = passes ? Verdict::explained : Verdict::partly_explained;

  const SmoothFit after = bench.fit(bench.basis(), bench.used(), bench.accepted_columns(), bench.prior());
  result.residual_before = before.residual;
  result.residual_after = after.residual;
  for (std::size_t i = 0; i < bench.used().size(); ++i)
    if (!bench.used()[i]) result.outliers.push_back(i);
  result.holdout = bench.split().holdout;
  result.has_holdout = bench.split().has_holdout();
  result.problem = bench.problem();
  result.bare_model = model_of(bench.problem(), before, machine);
  result.model = model_of(bench.problem(), after, machine);
  fill_values(result, bench, after);
  for (std::size_t k = 0; k < bench.accepted.size(); ++k) {
    describe_confounding(result.effects[k], bench, screen, k);
    suspend_if_undecided(result, k);
  }
  list_untestable(result, bench, screen);
}

}  // namespace trunnion
