#pragma once

#include <span>
#include <string>

#include "testpiece/tool_path.h"

namespace trunnion {

/// The path as a program for LinuxCNC with its tool centre point held by the kinematics: X Y Z are the tip in W, so
/// that the work offset is W's zero. One block a position, preceded and followed by a clearance of 5 mm along the
/// outward normal at the start. `tilt_letter`: A or B.
std::string piece_program(const TestPiece& piece, std::span<const ToolPosition> path, char tilt_letter);

}  // namespace trunnion
