#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "model/catalogue.h"
#include "planning/probing_plan.h"

namespace trunnion {

/// Effects to be seen, and to be told from one another, beside smooth maps of the rotary axes.
struct PowerQuestion {
  std::vector<std::string> effects;  ///< one id, or two
};

/// The smallest size of one parameter that is found nine times in ten (a noncentrality of 25.6).
struct SmallestSeen {
  std::string effect, parameter;
  Unit unit = Unit::one;
  double size = 0;  ///< inside units; infinite: cannot be seen
};

/// What further visits would bring.
struct PowerPlan {
  std::vector<Visit> visits;
  std::vector<SmallestSeen> before, after;  ///< parameter by parameter, each effect told from the other
};

/// What the next visits may take.
struct PowerOptions {
  std::size_t visits = 6;
  double most_s = std::numeric_limits<double>::infinity();  ///< that the visits may take together
  PlanOptions pace;
  std::function<void(std::size_t visits)> progress = {};  ///< told how many visits are chosen
};

/// The visits after those of `so_far` that tell most about the effects: one after the other, each the best of some two
/// hundred positions and ways to come to them, by the determinant of what is known of the parameters outside the maps'
/// and the measurement's unknowns (field of optimal design: Fedorov 1972); fewer visits where the time is up. Throws
/// UsageError for an effect that no such readings can show, naming what would.
PowerPlan plan_for_power(const ObservationSet& so_far, const Machine& machine, const std::vector<Spot>& spots,
                         const PowerQuestion& question, const PowerOptions& options);

}  // namespace trunnion
