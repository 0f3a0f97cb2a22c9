#pragma once

#include "compensation/controller.h"

namespace trunnion {

/// The number of the profile that says how fast corrections may change: the same for every controller.
ProfileNumber slope_limit();

/// Throws RangeError, naming pose, value and key, where what `played` adds exceeds the limits of the machine file: the
/// deviation and the tilt that are corrected, how far C goes for the latter ([limits]), and how steeply corrections
/// change along A and C (profile.table_slope).
void refuse_beyond_limits(const Controller& controller, const CompensationTask& task,
                          const std::vector<Situation>& sample, const PlayedCompensation& played);

}  // namespace trunnion
