#pragma once

#include <vector>

#include "discovery/closure_case.h"

namespace trunnion::testing {

/// Effects that no catalogue has and that are built from none of its candidates: in place, time, angle, approach and
/// columns without a known name, smooth and abrupt, of the machine and of the measurement.
const std::vector<Invention>& inventions();

}  // namespace trunnion::testing
