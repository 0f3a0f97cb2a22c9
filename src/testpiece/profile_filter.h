#pragma once

#include <vector>

#include "testpiece/roundness.h"

namespace trunnion {

/// The phase-correct Gaussian filter for closed profiles (ISO 16610-21 as used by ISO 12181-2): undulation k passes
/// with
///   exp(-pi (alpha k / cutoff)^2),  alpha = sqrt(ln 2 / pi),
/// one half at k = cutoff undulations per revolution. Points may stand unevenly: each counts with its share of the
/// turn. Throws UsageError unless cutoff_upr > 0.
RoundnessTrace gaussian_filtered(const RoundnessTrace& trace, double cutoff_upr);

/// One undulation a cos(k phi - phase).
struct Undulation {
  int per_turn = 0;
  double amplitude_mm = 0;
  double phase_rad = 0;
};

/// The undulations 0 … highest of a trace (0: the mean, with phase 0 and its sign in the amplitude); points count with
/// their share of the turn, which is exact for even spacing while 2 * highest is below the number of points.
std::vector<Undulation> undulations(const RoundnessTrace& trace, int highest);

}  // namespace trunnion
