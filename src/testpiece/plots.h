#pragma once

#include <span>
#include <string>
#include <vector>

#include "testpiece/cone_evaluation.h"

namespace trunnion {

// Whole SVG documents that stand by themselves, black on white. A page that they are set into may give them its own
// colours: their classes are `paper`, `grid`, `axis`, `line s0` … `line s5`, and text.

/// One closed line of a polar plot.
struct PolarCurve {
  std::string label;
  RoundnessTrace radial;
};

/// A roundness plot: each trace less its own least squares circle, magnified about one circle,
/// with rings every division and the division's size in um. The text says of each its LSC and MZC roundness.
std::string polar_plot_svg(const std::string& title, std::span<const PolarCurve> curves);

/// Deviations over the unrolled flank, phi to the right and height upward, with a colour bar in
/// um that ends at `end_um` (round_scale). `deviation_mm` row by row: [i_height * phi + k], phi evenly from 0, heights
/// ascending.
std::string unrolled_map_svg(const std::string& title, std::size_t phi_count, std::span<const double> heights_mm,
                             std::span<const double> deviation_mm, double end_um);

}  // namespace trunnion
