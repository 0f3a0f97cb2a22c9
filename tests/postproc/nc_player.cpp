#include "nc_player.h"

#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>

namespace trunnion::testing {

std::vector<PlayedMove> play_rs274(std::string_view program, const std::array<double, 3>& offset_mm, char tilt) {
  std::vector<PlayedMove> moves;
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  std::array<double, 5> at{unknown, unknown, unknown, unknown, unknown};
  std::array<double, 5> zero{offset_mm[0], offset_mm[1], offset_mm[2], 0, 0};
  double unit = 1, feed = 0, feed_mm = 0;
  bool incremental = false, feeding = false, inverse = false;
  const std::string letters = std::string("XYZ") + tilt + "C";
  while (!program.empty()) {
    std::string line(program.substr(0, program.find('\n')));
    program.remove_prefix(std::min(program.size(), line.size() + 1));
    std::multimap<char, double> words;
    std::string plain;
    for (bool comment = false; const char c : line) {
      if (c == ';') break;
      if (c == '(') comment = true;
      if (!comment && c != ' ' && c != '\r' && c != '%') plain += static_cast<char>(std::toupper(c));
      if (c == ')') comment = false;
    }
    for (const char* p = plain.c_str(); *p != '\0';) {
      const char letter = *p++;
      if (*p == '+') ++p;
      double value = 0;
      p = std::from_chars(p, plain.c_str() + plain.size(), value).ptr;
      words.emplace(letter, value);
    }
    if (words.contains('F')) {
      feed = words.find('F')->second;
      feed_mm = feed * unit;  // a G20 in the same block comes later
    }
    bool set_position = false, machine_coordinates = false;
    for (auto [first, last] = words.equal_range('G'); first != last; ++first) {
      const double g = first->second;
      if (g == 0) feeding = false;
      if (g == 1) feeding = true;
      if (g == 20) unit = 25.4;
      if (g == 21) unit = 1;
      if (g == 90) incremental = false;
      if (g == 91) incremental = true;
      if (g == 92) set_position = true;
      if (g == 93) inverse = true;
      if (g == 94) inverse = false;
      if (g == 53 || g == 28) machine_coordinates = true;
    }
    if (words.contains('M') && words.find('M')->second == 6) at.fill(unknown);
    bool moves_now = false;
    const std::array<double, 5> from = at;
    for (std::size_t i = 0; i < 5; ++i) {
      const auto word = words.find(letters[i]);
      if (word == words.end()) continue;
      const double value = word->second * (i < 3 ? unit : 1);
      if (set_position) {
        zero[i] = at[i] - value;
      } else if (machine_coordinates) {
        at[i] = unknown;
      } else {
        at[i] = incremental ? at[i] + value : value + zero[i];
        moves_now = true;
      }
    }
    if (!moves_now) continue;
    bool known = true;
    for (const double value : at) known = known && !std::isnan(value);
    if (!known) continue;
    PlayedMove move{at, 0};
    if (feeding && feed > 0) {
      const double length = std::hypot(at[0] - from[0], at[1] - from[1], at[2] - from[2]);
      const double turn = std::hypot(at[3] - from[3], at[4] - from[4]);
      move.minutes = inverse ? 1 / feed : length > 0 ? length / feed_mm : turn / feed;
    }
    moves.push_back(move);
  }
  return moves;
}

}  // namespace trunnion::testing
