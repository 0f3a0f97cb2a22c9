#pragma once

#include <optional>
#include <vector>

#include "kinematics/kinematic_chain.h"
#include "probing/observation.h"

namespace trunnion {

/// One reading of the commands: each rotary axis in the file's sense or the other, angles in deg or rad.
struct AngleReading {
  bool tilt_reversed = false, turn_reversed = false, radians = false;
  friend bool operator==(const AngleReading&, const AngleReading&) = default;
};

/// How well the nominal machine carries the touched spots from pose to pose when commands are read so:
///   x = R1 R2 w_k + (I - R1) o1 + R1 (I - R2) o2
/// over the axes that carry the table, from R outward, with the place w_k of every spot in W and the offset of every
/// axis line from its place in the machine file as unknowns (least squares, shortest solution).
struct NominalFit {
  AngleReading reading;
  double rms_mm = 0;  ///< of what the places miss, all three components
  /// Where the line of each table axis passes, less its place in the machine file, across its direction; R, mm.
  std::vector<Eigen::Vector3d> line_offset_mm;
  std::vector<char> letters;  ///< of these axes, from R outward
};

/// Fits of all ways to read the commands; the file's own first. Empty if no row tells a place in R, no axis carries the
/// table, or no spot was seen at two positions.
std::vector<NominalFit> nominal_fits(const ObservationSet& observations, const Machine& machine);

}  // namespace trunnion
