#pragma once

#include "discovery/closure.h"
#include "discovery/screen.h"
#include "discovery/workbench.h"

namespace trunnion {

/// Fits what was accepted to all readings, beside the bare map at the same prior, and fills in what `result` lacks:
/// stages, verdict, models, residuals, sizes and alternatives of each effect, what cannot be tested. `result.effects`
/// holds the evidence of `bench.accepted`, one for one.
void conclude(ClosureResult& result, Workbench& bench, Screen& screen, const Machine& machine,
              const ClosureOptions& options);

}  // namespace trunnion
