#pragma once

#include "discovery/workbench.h"

namespace trunnion {

/// A map with more freedom than the one at hand, and the restricted log likelihood that it gains over it.
struct RicherMap {
  HarmonicBasis basis;
  double gain = 0;
};
/// The best enlargement of the rotary maps: more degrees of the tilt, more harmonics of C, more of their products, or
/// all of these. What an enlargement adds is a Gaussian process beside the map as it stands, its variances those that
/// the map's prior has for these functions, times a factor that the readings choose.
RicherMap best_richer_map(const Workbench& bench);

}  // namespace trunnion
