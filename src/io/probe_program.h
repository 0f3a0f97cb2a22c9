#pragma once

#include <string>
#include <string_view>

#include "io/observation_file.h"
#include "kinematics/machine.h"
#include "probing/observation.h"

namespace trunnion {

/// How the probe moves.
struct ProbeMoves {
  double clearance_mm = 40;  ///< above whatever stands on the table, for moves between spots
  double standoff_mm = 8;    ///< of the ball from the face before it is probed
  double overtravel_mm = 4;  ///< beyond the nominal face, until the move fails
  double feed_mm_per_min = 60;
  double overshoot_deg = 5;  ///< by which a rotary axis passes a position that it has to come back to
};

/// A program for LinuxCNC (RS274/NGC: G38.2, LOG comments) that takes the readings of a plan. X, Y and Z are R's
/// coordinates in the work offset that is active, whatever A and C are (no tool-centre-point control), the tool length
/// that of the ball's centre. It retracts above everything before a rotary axis moves, stops where a face is not met,
/// and writes `log_name`. Throws RefusalError where a move would leave a stroke, or a rotary axis carries
/// the tool, UsageError for a label that a comment cannot hold.
std::string linuxcnc_probe_program(const ObservationSet& plan, const Machine& machine, const ProbeMoves& moves,
                                   const std::string& log_name);

/// The log of such a program as readings: contact points in R, the ball's radius taken off along the approach. Throws
/// InputError naming line, what was found and what is wanted.
ObservationSet parse_probe_log(std::string_view text, const std::string& name, const Machine& machine,
                               const ReadingProgress& progress = {});

}  // namespace trunnion
