#pragma once

#include <string>

#include "testpiece/tool_path.h"

namespace trunnion {

/// The piece as a solid in STEP (AP242, mm, in W): the frustum on a square block below its base, within the base's
/// circle so that the overhanging tool clears it. Made by OpenCASCADE in `module`, the shared object trunnion_brep,
/// which is loaded for it. Throws ModelError where it cannot be loaded, or made.
std::string piece_step(const TestPiece& piece, const std::string& module);

/// The flank's rulings as the solid's own surface has them, for flank_milling_path. Throws as piece_step.
Rulings solid_rulings(const TestPiece& piece, const std::string& module);

/// Where the program's own module lies: beside it, or in the library folder of its installation; empty if in neither.
std::string brep_module();

/// What a STEP text holds, read back by the module.
struct MeasuredSolid {
  double volume_mm3 = 0;
  int faces = 0;
  Angle semi_angle;  ///< of its conical face; 0: none
};
MeasuredSolid measured_solid(const std::string& step, const std::string& module);

}  // namespace trunnion
