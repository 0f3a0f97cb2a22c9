#include "kinematics/structure.h"

#include <algorithm>
#include <string_view>

#include "error.h"

namespace trunnion {
namespace {

[[noreturn]] void refuse(const std::string& code, const std::string& what) {
  throw ModelError("structure \"" + code + "\": " + what + "; wanted is a code like \"w C' A' Y' b X Z t\"");
}

}  // namespace

Structure parse_structure(const std::string& code) {
  Structure structure{.code = code, .joints = {}};
  enum class Place { before_workpiece, workpiece_side, tool_side, after_tool } place = Place::before_workpiece;
  for (std::size_t i = 0; i < code.size(); ++i) {
    const char symbol = code[i];
    if (symbol == ' ') continue;
    if (place == Place::after_tool) refuse(code, "something follows the tool t");
    if (symbol == 'w' && place == Place::before_workpiece) {
      place = Place::workpiece_side;
    } else if (symbol == 'b' && place == Place::workpiece_side) {
      place = Place::tool_side;
    } else if (symbol == 't' && place == Place::tool_side) {
      place = Place::after_tool;
    } else if (std::string_view("XYZABC").find(symbol) != std::string_view::npos) {
      const bool primed = i + 1 < code.size() && code[i + 1] == '\'';
      if (place == Place::before_workpiece) refuse(code, "it does not begin with the workpiece w");
      if (primed != (place == Place::workpiece_side))
        refuse(code, std::string("axis ") + symbol +
                         (primed ? "' is primed on the tool side" : " has no prime on the workpiece side"));
      structure.joints.push_back({symbol, primed ? Side::workpiece : Side::tool});
      if (primed) ++i;
    } else {
      refuse(code, std::string("'") + symbol + "' was not expected there");
    }
  }
  if (place != Place::after_tool) refuse(code, "it does not end with the tool t");
  const auto count = [&](char letter) { return std::ranges::count(structure.joints, letter, &Joint::letter); };
  for (const char letter : {'X', 'Y', 'Z', 'C'})
    if (count(letter) != 1)
      refuse(code, std::string("axis ") + letter + " occurs " + std::to_string(count(letter)) + " times");
  if (count('A') + count('B') != 1) refuse(code, "exactly one of the tilting axes A and B is wanted");
  return structure;
}

}  // namespace trunnion
