#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "conventions/check.h"
#include "kinematics/kinematic_chain.h"
#include "kinematics/machine.h"

namespace trunnion {

/// One stop of the sign test.
struct SignStep {
  IndexedPosition at;
  char moved = ' ';  ///< the rotary axis that came to it; blank for the start
};

/// Two poses an axis: the start at A = C = 0, C at +30 deg, back, the tilting axis at 20 deg to the side where its
/// stroke is longer.
std::vector<SignStep> sign_steps(const Machine& machine);

/// The test as a short program. It moves the rotary axes only, one at a time, and stops at each position for a mark on
/// the table to be touched by hand. `dialect` is linuxcnc, fanuc, sinumerik or heidenhain; plain: ISO words alone.
std::string sign_program(const Machine& machine, const std::string& dialect);

/// What stands before the machine's serial number in a comment line of the form.
inline constexpr std::string_view kFormSerial = "# Serial number: ";

/// The form beside it (CSV): a row a stop, with blanks for the machine's X Y Z at which the tool met the mark, and in
/// its comment lines where that should be for a mark at W (70, 70, 0).
std::string sign_form(const Machine& machine);

/// A row of the form as it was filled in.
struct FilledStep {
  IndexedPosition at;
  Eigen::Vector3d xyz_mm = Eigen::Vector3d::Zero();
};

/// Whether the mark went where the machine file says, axis by axis: the place of every stop from that of the first,
/// with the axis in the file's sense and in the other. `tool_length_mm` counts where an axis carries the tool: X Y Z
/// are then those of the spindle nose. Throws UsageError for rows that are not those of the form.
Checks sign_verdict(const Machine& machine, const std::vector<FilledStep>& filled, double tool_length_mm);

}  // namespace trunnion
