#pragma once

#include <string>
#include <vector>

#include "support/noise.h"
#include "support/probing_plan.h"
#include "support/virtual_machine.h"

namespace trunnion::testing {

/// The effects that add_undeclared knows. Up to a slash they are named as closure.json names them; what follows the
/// slash is one way among several in which that effect shows.
std::vector<std::string> undeclared_ids();

/// How large an effect is and over what it extends.
struct UndeclaredSize {
  double scale = 1;  ///< of its amplitude; 1 is what a probe of 0.2 um finds in three passes
  double duration_s = 5000;
  int touches = 657;
};

/// Adds one undeclared effect, its parameters drawn from `noise`: the same draws whatever the size. Throws
/// std::invalid_argument for an id it does not know.
void add_undeclared(VirtualMachine& machine, const std::string& id, Noise& noise, const UndeclaredSize& size = {});

/// Writes the covariates that `id` depends on into the plan: a temperature that wanders, a clamp that opens and closes,
/// a load that is taken off and put on again. Nothing for the other effects.
void record_covariates(ProbingPlan& plan, const std::string& id);

}  // namespace trunnion::testing
