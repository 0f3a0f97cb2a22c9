#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "discovery/closure.h"
#include "support/probing_plan.h"
#include "support/smooth_machine.h"
#include "support/undeclared_draw.h"

namespace trunnion::testing {

/// What is probed: one pass of 294 touches on 18 spots, also with 24 other poses later; three passes of 219 touches on
/// 15 spots, the second reversed, the third with A rising, also with the 24 other poses.
enum class Measured { calibration, verified, three_passes, three_passes_verified };

/// An effect that no catalogue has: `add` puts it into the machine, `scale` times as large as it comes.
struct Invention {
  std::string name;
  std::function<void(VirtualMachine&, Noise&, const UndeclaredSize&)> add;
  std::function<void(ProbingPlan&)> record;  ///< covariates it needs; may be empty
  bool of_the_machine = true;
};

/// A machine with smooth maps, and undeclared effects, each as large as it has to be.
struct ClosureCase {
  std::uint64_t seed = 0;
  std::vector<std::string> effects;  ///< ids for add_undeclared
  const Invention* invention = nullptr;
  Measured measured = Measured::verified;
  /// Noncentrality |P z|^2 that each effect z has in the readings that are searched, beside a smooth map; 0: as large
  /// as add_undeclared makes it.
  double noncentrality = 0;
  TouchNoise noise{.sigma_mm = 0.175e-3};
  SmoothMachineOptions machine;
};

struct ClosureOutcome {
  VirtualMachine machine;
  ClosureResult closure;
  bool visible = true;  ///< no effect had to be made more than ten times as large as it comes

  /// Whether `id` (up to a slash) was accepted, or something that it is said not to be told from.
  bool found(const std::string& id) const;
};
ClosureOutcome close_case(const ClosureCase& c);

/// Root mean square error of a model's deviation, um, at places all over the probed range: each under the conditions
/// (time, temperature, senses of motion, further columns) of one of the touches from which it was found.
double map_error_um(const Model& model, const ClosureOutcome& outcome);

}  // namespace trunnion::testing
