#pragma once

#include "postproc/path_trace.h"
#include "postproc/program_correction.h"

namespace trunnion {

/// Errors along a path: of the tip, mm, and of the tool axis, rad, seen from the workpiece.
struct PathError {
  double largest_tip_mm = 0;
  double rms_tip_mm = 0;
  double largest_tilt_rad = 0;
  double rms_tilt_rad = 0;
  std::uint64_t tip_line = 0;  ///< of the original, where the largest is met
  std::uint64_t tilt_line = 0;
};

/// How much of a limit of the machine file, or of what was probed, the written program uses.
struct LimitUse {
  std::string limit;                          ///< axis.X.range_mm, limits.correction_um ...: as the file calls it
  std::string unit;                           ///< mm, deg, um, urad
  std::optional<double> low, allowed_low;     ///< a range; none: only the largest counts
  double high = 0, allowed_high = 0;          ///< the largest
  std::uint64_t low_line = 0, high_line = 0;  ///< of the original, where they are met
};

/// What play_back found.
struct PlaybackResult {
  std::uint64_t moves = 0;    ///< blocks of the original that were compared
  std::uint64_t samples = 0;  ///< places looked at: ends of what was written, and the middles of feed moves
  PathError before;           ///< of the original program on the machine
  PathError after;            ///< of what was written
  PathTrace along;            ///< the same along the program
  std::vector<LimitUse> limits;
  std::uint64_t refused = 0;      ///< blocks that were copied as they are, and are not compared
  std::uint64_t copied_from = 0;  ///< the line from which on all is copied; 0: none
};

/// A place of a program's feed moves.
struct PlayedPlace {
  std::uint64_t line = 0;
  AxisValues at{};  ///< work offset included, mm and deg
  bool tcp = true;  ///< X Y Z are of W, else of R
};

/// Where a program goes at feed, by the same plain reader: the ends of its moves and as many places between as keep two
/// of them within `step_mm` and `step_deg`. Moves with an axis not yet known are passed over.
std::vector<PlayedPlace> played_places(const OpenProgram& program, const ScanSettings& settings, double step_mm,
                                       double step_deg, const std::string& dialect = "linuxcnc");

/// Plays a program and its correction on the machine as the corrector's field tells it, exactly and by the plain
/// transforms, read by a second, plain reader that shares no code with the scan; compares where the tool goes with
/// where the nominal machine would have brought it. Of the corrector nothing is used but chain, field and tool.
/// `correction` says only which lines were inserted, and which refused and copied: those are passed over, and so is
/// what comes behind them until all axes are known again. Throws InputError where the two programs do not belong
/// together.
PlaybackResult play_back(const OpenProgram& original, const OpenProgram& corrected, const Corrector& corrector,
                         const ProgramCorrection& how, const ProgramCorrectionResult& correction);

}  // namespace trunnion
