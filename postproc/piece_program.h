#pragma once

#include <span>
#include <string>

#include "postproc/motion.h"
#include "testpiece/tool_path.h"

namespace trunnion {

/// Whose program it is to be.
struct PieceProgramStyle {
  std::string dialect = "linuxcnc";
  char tilt_letter = 'A';
  ControlFacts control;
  bool modulo_turn = true;                                   ///< C counts round and round
  Eigen::Vector3d work_offset_mm = Eigen::Vector3d::Zero();  ///< of G54: where the program's zero stands in W
};

/// The path as a program under tool-centre-point control: X Y Z are the tip in W, counted from the work offset, one
/// block a position. LinuxCNC holds the tip by its kinematics; the other controls are told to (G43.4 H1, TRAORI, M128),
/// with the rotary axes in place before, at zero where the control's frame begins where it is switched on, and X Y Z
/// those of the part at the block's end where it does not turn with the table (ControlFacts). The tool comes down along
/// its own axis from above the piece, 5 mm clear of it along the outward normal, and leaves the same way. Spindle and
/// coolant are left to the operator. Lengths have five decimals and angles six; four each for controls that take no
/// more (FANUC, HEIDENHAIN).
std::string piece_program(const TestPiece& piece, std::span<const ToolPosition> path, const KinematicChain& chain,
                          const PieceProgramStyle& style = {});

}  // namespace trunnion
