#pragma once

#include "conventions/check.h"
#include "kinematics/machine.h"

namespace trunnion {

/// What a machine file says by itself: rotation senses in words, numbers that look like radian or inch, whether the
/// axes cross at R's origin, whether the reference pose lies within the strokes; and two laws executed on this very
/// machine:
///   gauge: every map is zero at the reference pose, and where one side carries both axes, constants of the twelve
///     errors move the table as the eight location errors can and no further (ISO 230-7: two axis lines have eight);
///   origin shift: with R's origin elsewhere, axes and points told from there, every deviation stays what it was.
Checks machine_checks(const Machine& machine);

}  // namespace trunnion
