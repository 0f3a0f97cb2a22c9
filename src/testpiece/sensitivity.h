#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "model/catalogue.h"
#include "testpiece/machining.h"

namespace trunnion {

/// One error, alone and of a given amount, and what the piece shows of it.
struct Sensitivity {
  std::string error;  ///< "EX0C", "EXC cos 2C", "EAA A^2"
  double amount = 0;  ///< in `unit`
  Unit unit = Unit::um;
  ConeEvaluation shown;
  double size_mm = 0;  ///< diameter less nominal, mean over the heights
  /// In what a measuring machine tells after it has set the part up: "roundness", "form" (of the flank as a whole),
  /// "size", "half angle"; place and axis of the part are its set-up and do not count. Empty: it sees nothing.
  std::vector<std::string> seen_in;
  bool seen_in_roundness() const;
};

/// The amount of each error, and when it counts as seen.
struct SensitivityOptions {
  Length length = Length::micrometres(10);    ///< amount of a translation
  Angle angle = Angle::microradians(50);      ///< amount of a rotation
  Length visible = Length::micrometres(0.1);  ///< least roundness (LSC), form or size that counts as seen
};

/// What the piece shows of each of the eight location errors, and of each error motion up to order 3 by itself: of the
/// tilting axis its powers 1 to 3, scaled to `amount` at the steepest tilt of the path; of C the harmonics 1 to 3,
/// cosine and sine; and of the backlash of either rotary axis. Of the linear axes likewise: squarenesses, scale (order
/// 1), straightness (2 and 3), pitch, yaw and roll (1), reversals; each motion reaches `amount` somewhere on the path.
/// All relative to the reference pose, to first order.
std::vector<Sensitivity> sensitivities(const TestPiece& piece, const EffectContext& context,
                                       const SensitivityOptions& options = {});

/// Whether the machine can go along a path.
using Reachable = std::function<bool(std::span<const ToolPosition>)>;

/// A piece of the same size, tool and table place that shows more of the location errors: the half angle, tilt and
/// height above the table at which the least visible of those that any cone shows is largest.
struct BetterPiece {
  TestPiece piece;
  double least_seen_mm = 0;        ///< roundness of the least visible location error there …
  double least_seen_here_mm = 0;   ///< … and on the piece given
  std::vector<std::string> never;  ///< location errors that no cone of the search shows in its roundness
};
BetterPiece better_piece(const TestPiece& piece, const EffectContext& context, const Reachable& reachable,
                         const SensitivityOptions& options = {});

}  // namespace trunnion
