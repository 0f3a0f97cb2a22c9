#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace trunnion::testing {

/// Where a plain RS274 program has brought X Y Z A (or B) C after one of its moves, in mm and degrees, work offset
/// included.
struct PlayedMove {
  std::array<double, 5> at{};
  double minutes = 0;  ///< how long G1 takes after LinuxCNC's rules; 0 for G0
};

/// Reads a program of numbered words with an if per code, sharing nothing with postproc: G0 G1 G20 G21 G90 G91
/// G92 G93 G94 and G54 with `offset_mm`. Moves before all five axes are known are left out.
std::vector<PlayedMove> play_rs274(std::string_view program, const std::array<double, 3>& offset_mm, char tilt = 'A');

}  // namespace trunnion::testing
