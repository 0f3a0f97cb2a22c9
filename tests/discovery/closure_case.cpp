#include "discovery/closure_case.h"

#include <algorithm>
#include <cmath>

#include "discovery/workbench.h"
#include "identification/as_observations.h"
#include "identification/whitened_change.h"

namespace trunnion::testing {
namespace {

constexpr double kLargestScale = 10, kLaterStart_s = 6000;
constexpr int kRescalings = 3;

struct Plans {
  ProbingPlan calibration, later;  ///< the second one empty where there is none
};

Plans plans_of(const ClosureCase& c, Noise& noise) {
  const bool passes = c.measured == Measured::three_passes || c.measured == Measured::three_passes_verified;
  Plans plans{passes ? replica_plan() : two_top_plan(), {}};
  plans.calibration.faces = as_built(plans.calibration.faces, noise, 20e-3, 50e-6);
  if (passes) plans.calibration = three_passes(plans.calibration);
  if (c.measured == Measured::verified || c.measured == Measured::three_passes_verified) {
    const double start_s = std::max(kLaterStart_s, plans.calibration.touches.back().time_s + 600);
    plans.later =
        verification_plan(plans.calibration.faces, {.seed = c.seed + 1},
                          {.start_s = start_s, .first_order = static_cast<int>(plans.calibration.touches.size())});
  }
  for (ProbingPlan* plan : {&plans.calibration, &plans.later}) {
    for (const std::string& id : c.effects) record_covariates(*plan, id);
    if (c.invention != nullptr && c.invention->record) c.invention->record(*plan);
  }
  return plans;
}

struct Readings {
  ObservationSet set;
  std::size_t verification_from = 0;
};
Readings measured(const VirtualMachine& machine, const Plans& plans, const TouchNoise& touch_noise, Noise noise) {
  Readings r{as_observations(probe(machine, plans.calibration, touch_noise, noise), "calibration.csv")};
  r.verification_from = r.set.rows.size();
  if (!plans.later.touches.empty())
    r.set = joined(r.set, as_observations(probe(machine, plans.later, touch_noise, noise), "verification.csv"));
  return r;
}

using Add = std::function<void(VirtualMachine&, double scale)>;

/// The scale at which an effect has the noncentrality asked for.
double scale_for(double noncentrality, const Add& add, const VirtualMachine& machine, const Plans& plans,
                 const TouchNoise& noise) {
  const Readings plain = measured(machine, plans, {.sigma_mm = noise.sigma_mm}, Noise(1));
  Workbench bench(plain.set, plain.verification_from, plain_machine(), 5);
  bench.refit(bench.searched());
  const Readings without = measured(machine, plans, {}, Noise(1));
  double scale = 1;
  for (int round = 0; round < kRescalings; ++round) {
    VirtualMachine changed = machine;
    add(changed, scale);
    const Readings with = measured(changed, plans, {}, Noise(1));
    const Eigen::VectorXd z = whitened_change(bench.problem(), with.set, without.set);
    const double found = z.dot(bench.smooth().apply(z).col(0));
    if (found <= 0) return kLargestScale;
    scale = std::min(kLargestScale, scale * std::sqrt(noncentrality / found));
  }
  return scale;
}

}  // namespace

bool ClosureOutcome::found(const std::string& id) const {
  const std::string wanted = id.substr(0, id.find('/'));
  return std::ranges::any_of(closure.effects, [&](const AcceptedEffect& e) {
    return e.effect->id() == wanted || std::ranges::find(e.not_separable_from, wanted) != e.not_separable_from.end();
  });
}

ClosureOutcome close_case(const ClosureCase& c) {
  ClosureOutcome outcome{.machine = smooth_machine(5000 + c.seed, c.machine)};
  Noise noise(9000 + c.seed);
  const Plans plans = plans_of(c, noise);
  const UndeclaredSize whole{.duration_s = plans.calibration.touches.back().time_s,
                             .touches = static_cast<int>(plans.calibration.touches.size())};
  std::vector<Add> adds;
  for (const std::string& id : c.effects)
    adds.push_back([id, whole, draws = Noise(noise.bits())](VirtualMachine& machine, double scale) {
      Noise same = draws;
      UndeclaredSize size = whole;
      size.scale = scale;
      add_undeclared(machine, id, same, size);
    });
  if (c.invention != nullptr)
    adds.push_back([&c, whole, draws = Noise(noise.bits())](VirtualMachine& machine, double scale) {
      Noise same = draws;
      UndeclaredSize size = whole;
      size.scale = scale;
      c.invention->add(machine, same, size);
    });
  const VirtualMachine bare = outcome.machine;
  for (const Add& add : adds) {
    double scale = 1;
    if (c.noncentrality > 0) scale = scale_for(c.noncentrality, add, bare, plans, c.noise);
    outcome.visible = outcome.visible && scale < kLargestScale;
    add(outcome.machine, scale);
  }
  Readings readings = measured(outcome.machine, plans, c.noise, Noise(noise.bits()));
  static std::vector<std::unique_ptr<ObservationSet>> kept;  // a result points into its observations
  kept.push_back(std::make_unique<ObservationSet>(std::move(readings.set)));
  outcome.closure = close_loop(*kept.back(), readings.verification_from, plain_machine());
  return outcome;
}

double map_error_um(const Model& model, const ClosureOutcome& outcome) {
  const std::vector<Situation>& touched = outcome.closure.problem.situations;
  constexpr int kPlaces = 300;
  Noise places(99);
  double sum = 0;
  for (int k = 0; k < kPlaces; ++k) {
    Situation s = touched[places.below(touched.size())];
    const double a = -90 * places.uniform(), c = 360 * places.uniform();
    s.at = {Angle::degrees(a), Angle::degrees(c)};
    s.point_r_mm = {places.uniform(-100, 100), places.uniform(-100, 100), places.uniform(60, 110)};
    s.approach_r.setZero();
    s.reading = ReadingKind::none;
    MachineState state;
    state.rotary = ac_degrees(a, c);
    state.tip_r_mm = s.point_r_mm;
    state.time_s = s.time_s;
    state.temperature_C = s.temperature_C;
    state.rotary_sense = {static_cast<double>(s.tilt_sense), 1, static_cast<double>(s.turn_sense)};
    state.linear_sense = s.linear_sense;
    state.order = static_cast<int>(s.order);
    state.order_in_pose = static_cast<int>(s.order_in_pose);
    state.repeat = s.repeat;
    for (std::size_t j = 0; s.extra.names != nullptr && j < s.extra.names->size(); ++j)
      state.covariates[(*s.extra.names)[j]] = s.extra.values[j];
    sum += (deviation_mm(model, s) - outcome.machine.deviation_mm(state)).squaredNorm();
  }
  return 1e3 * std::sqrt(sum / kPlaces);
}

}  // namespace trunnion::testing
