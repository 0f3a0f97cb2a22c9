#pragma once

#include <string>

#include "discovery/closure.h"
#include "identification/as_observations.h"
#include "support/probing_plan.h"
#include "support/smooth_machine.h"

namespace trunnion::testing {

/// A machine with smooth maps, calibrated on 18 spots and verified later at 24 other positions, with one undeclared
/// effect.
struct UndeclaredCase {
  std::uint64_t seed = 0;
  std::string effect;  ///< id for add_undeclared; empty: nothing is missing
  int C_harmonics = 2;
  TouchNoise noise{.sigma_mm = 0.175e-3};
  bool verification = true;
};

struct UndeclaredOutcome {
  VirtualMachine machine;
  ClosureResult closure;

  bool found(const std::string& id) const {
    for (const AcceptedEffect& e : closure.effects) {
      if (e.effect->id() == id) return true;
      for (const std::string& other : e.not_separable_from)
        if (other == id) return true;
    }
    return false;
  }
};

inline UndeclaredOutcome close_case(const UndeclaredCase& c) {
  UndeclaredOutcome outcome{.machine = smooth_machine(5000 + c.seed, {.C_harmonics = c.C_harmonics})};
  Noise noise(9000 + c.seed);
  if (!c.effect.empty()) add_undeclared(outcome.machine, c.effect, noise, 5000, 657);
  ProbingPlan calibration = two_top_plan();
  calibration.faces = as_built(calibration.faces, noise, 20e-3, 50e-6);
  const auto rows = probe(outcome.machine, calibration, c.noise, noise);
  ObservationSet set = as_observations(rows, "calibration.csv");
  const std::size_t calibration_rows = set.rows.size();
  if (c.verification) {
    ProbingPlan later = verification_plan(calibration.faces, {.seed = c.seed + 1},
                                          {.start_s = 6000, .first_order = static_cast<int>(rows.size())});
    set = joined(set, as_observations(probe(outcome.machine, later, c.noise, noise), "verification.csv"));
  }
  static std::vector<std::unique_ptr<ObservationSet>> kept;  // the result points into its observations
  kept.push_back(std::make_unique<ObservationSet>(std::move(set)));
  outcome.closure = close_loop(*kept.back(), calibration_rows, plain_machine());
  return outcome;
}

/// Root mean square error of a model's deviation at positions all over the probed range, um.
inline double map_error_um(const Model& model, const VirtualMachine& machine) {
  Noise places(99);
  double sum = 0, count = 0;
  for (int k = 0; k < 60; ++k) {
    const double a = -90 * places.uniform(), c = 360 * places.uniform();
    for (const double x : {-100.0, 100.0})
      for (const double y : {-100.0, 100.0}) {
        Situation s;
        s.at = {Angle::degrees(a), Angle::degrees(c)};
        s.point_r_mm = {x, y, 80};
        MachineState state;
        state.rotary = ac_degrees(a, c);
        state.tip_r_mm = s.point_r_mm;
        sum += (deviation_mm(model, s) - machine.deviation_mm(state)).squaredNorm();
        ++count;
      }
  }
  return 1e3 * std::sqrt(sum / count);
}

}  // namespace trunnion::testing
