#include "testpiece/colour_scale.h"

#include <algorithm>
#include <cmath>

namespace trunnion {

Colour deviation_colour(double share) {
  constexpr std::array<std::array<double, 3>, 5> kStops = {
      {{33, 102, 172}, {103, 169, 207}, {247, 247, 247}, {239, 138, 98}, {178, 24, 43}}};
  const double at = 2 * (std::clamp(share, -1.0, 1.0) + 1);
  const auto i = std::min<std::size_t>(static_cast<std::size_t>(at), kStops.size() - 2);
  const double part = at - static_cast<double>(i);
  Colour colour{};
  for (std::size_t c = 0; c < 3; ++c)
    colour[c] = static_cast<std::uint8_t>(std::lround((1 - part) * kStops[i][c] + part * kStops[i + 1][c]));
  return colour;
}

double round_scale(double largest) {
  if (!(largest > 1e-3)) return 1;
  const double power = std::pow(10, std::floor(std::log10(largest) + 1e-12));
  for (const double step : {1.0, 2.0, 5.0})
    if (largest <= step * power * (1 + 1e-9)) return step * power;
  return 10 * power;
}

}  // namespace trunnion
