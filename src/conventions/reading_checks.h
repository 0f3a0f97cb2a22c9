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

/// The step, mm, of which every coordinate of every contact is a multiple, from 0.01 um to 0.1 mm in steps of 1 2 5;
/// 0 for a finer one, and where there are fewer than thirty contacts.
double coordinate_step_mm(const ObservationSet& observations);

/// Whether contacts are rounded more coarsely than their declared sigma allows: rounding to a step q alone scatters by
/// q / sqrt(12), and is the same at every touch of one place, so that a search would take it for an effect. Id
/// "units.rounding".
Check rounding_check(const ObservationSet& observations, const Machine& machine);

}  // namespace trunnion
