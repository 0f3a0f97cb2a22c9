#include "testpiece/piece_program.h"

#include <charconv>

namespace trunnion {
namespace {

constexpr double kClearance_mm = 5;
constexpr double kUsualFeed_mm_per_min = 600;

void append_word(std::string& line, char letter, double value, int decimals) {
  char text[64];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, decimals).ptr;
  std::string number(text, end);
  if (number.find_first_not_of("-0.") == std::string::npos && number[0] == '-') number.erase(0, 1);
  line += std::string(" ") + letter + number;
}

std::string block(const char* motion, const Eigen::Vector3d& tip_w_mm, IndexedPosition at, char tilt_letter) {
  std::string line = motion;
  for (Eigen::Index k = 0; k < 3; ++k) append_word(line, "XYZ"[k], tip_w_mm[k], 5);
  append_word(line, tilt_letter, at.a.in_degrees(), 6);
  append_word(line, 'C', at.c.in_degrees(), 6);
  return line;
}

}  // namespace

std::string piece_program(const TestPiece& piece, std::span<const ToolPosition> path, char tilt_letter) {
  const Eigen::Isometry3d frame = w_from_cone(piece.cone);
  const auto clear_of = [&](const ToolPosition& p) -> Eigen::Vector3d {
    const ConePoint on = cone_point(piece.cone, frame, Angle::radians(p.phi_rad), Length());
    return p.nominal.tip_w_mm + kClearance_mm * on.normal_w;
  };
  std::string text = "(cone frustum, flank milling, tool diameter ";
  std::string number;
  append_word(number, 'D', piece.tool.diameter.in_millimetres(), 3);
  text += number.substr(2) + " mm)\nG21 G90 G94 G17 G54\n";
  text += block("G0", clear_of(path.front()), path.front().at, tilt_letter) + "\n";
  std::string first = block("G1", path.front().nominal.tip_w_mm, path.front().at, tilt_letter);
  append_word(first, 'F', piece.feed_mm_per_min.value_or(kUsualFeed_mm_per_min), 1);
  text += first + "\n";
  for (const ToolPosition& p : path.subspan(1)) text += block("G1", p.nominal.tip_w_mm, p.at, tilt_letter) + "\n";
  text += block("G1", clear_of(path.back()), path.back().at, tilt_letter) + "\n";
  return text + "M2\n";
}

}  // namespace trunnion
