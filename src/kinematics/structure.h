#pragma once

#include <string>
#include <vector>

namespace trunnion {

/// On which side of the bed a joint stands in the structure code.
enum class Side { workpiece, tool };

/// One moving axis of the structure code.
struct Joint {
  char letter;
  Side side;
  friend bool operator==(const Joint&, const Joint&) = default;
};

/// The serial order of a five-axis machine after ISO 10791-6, from workpiece to tool: `w C' A' Y' b X Z t`, primed axes
/// on the workpiece side of the bed `b`.
struct Structure {
  std::string code;           ///< as written in the machine file
  std::vector<Joint> joints;  ///< from workpiece to tool
  friend bool operator==(const Structure&, const Structure&) = default;
};

/// Reads a structure code: blanks between the axes may be left out. Throws ModelError unless it runs from `w` over one
/// `b` to `t`, primes stand on the workpiece side only, X, Y, Z and C occur once each, and one of A and B.
Structure parse_structure(const std::string& code);

}  // namespace trunnion
