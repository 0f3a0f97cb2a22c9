#include "geometric_errors/symbol.h"

namespace trunnion {

std::string error_symbol(std::size_t component, char axis) {
  return std::string("E") + kComponentLetters[component] + axis;
}

std::array<LocationError, 8> location_errors(char tilt_letter) {
  // A shift or turn of the tilting axis along itself moves nothing; C's own are absorbed in the workpiece datum.
  const bool tilts_about_x = tilt_letter == 'A';
  const std::size_t across = tilts_about_x ? 1 : 0;  // the horizontal direction square to the tilting axis
  const auto name = [&](std::size_t component, char axis) {
    return std::string("E") + kComponentLetters[component] + '0' + axis;
  };
  return {{{name(across, tilt_letter), false, across},
           {name(2, tilt_letter), false, 2},
           {name(3 + across, tilt_letter), false, 3 + across},
           {name(5, tilt_letter), false, 5},
           {name(0, 'C'), true, 0},
           {name(1, 'C'), true, 1},
           {name(3, 'C'), true, 3},
           {name(4, 'C'), true, 4}}};
}

}  // namespace trunnion
