#pragma once

#include "conventions/check.h"
#include "kinematics/machine.h"
#include "probing/observation.h"

namespace trunnion {

/// What readings say about the conventions they were taken by: whether they move with the table as the machine file
/// says (rotation senses, degrees, the place of the axis lines), lie within the strokes, read as mm and um, contain the
/// reference pose; which columns they lack, and what could be seen with them; which freedoms of which poses no approach
/// sees, and which touches nothing checks.
Checks reading_checks(const ObservationSet& observations, const Machine& machine);

}  // namespace trunnion
