#pragma once

#include <array>
#include <cstdint>

namespace trunnion {

using Colour = std::array<std::uint8_t, 3>;  ///< sRGB

/// Blue (material missing) over near white (as wanted) to red (material left); `share` of the scale's end, -1 … 1,
/// beyond it the end's colour. Legible to the colour-blind.
Colour deviation_colour(double share);

/// The end of a scale in um that holds `largest`: 1, 2 or 5 times a power of ten; 1 for less than a nanometre, which is
/// nothing.
double round_scale(double largest);

}  // namespace trunnion
