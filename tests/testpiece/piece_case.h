#pragma once

#include <optional>

#include "discovery/closure.h"

namespace trunnion::testing {

/// A cone of 15 deg half angle, cut by the exact envelope on a machine with small smooth maps and perhaps an undeclared
/// backlash of C, measured by an independent measuring machine, and asked for its cause.
struct PieceCase {
  std::uint64_t seed = 0;
  double tilt_deg = 30;  ///< beyond the half angle C reverses twice; below it turns on and on
  double backlash_rad = 0;
  bool with_probing = false;  ///< joined with a calibration in which C never turns back
};

struct PieceOutcome {
  ClosureResult closure;
  std::optional<ClosureResult> probing_alone;  ///< what the calibration tells without the piece
  double roundness_before_um = 0;              ///< of what the model leaves of the piece, largest over the heights (LSC)
  double roundness_after_um = 0;
  /// "backlash:C" is among what was accepted, or cannot be told from it.
  bool names_the_backlash() const;
  /// The data are said not to be able to test a backlash of C.
  bool backlash_is_untestable() const;
};

/// The result stays valid until the program ends.
PieceOutcome close_piece(const PieceCase& c);

}  // namespace trunnion::testing
