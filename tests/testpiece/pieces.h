#pragma once

#include <string>

#include "kinematics/machine.h"
#include "testpiece/cone_frustum.h"

namespace trunnion {

/// A machine of the given structure with its usual axes through R's origin.
inline Machine trunnion_machine(const std::string& code = "w C' A' Y' b X Z t") {
  Machine machine{.name = "test", .structure = parse_structure(code)};
  machine.axes = default_axes(machine.structure);
  return machine;
}

/// The piece of the published sensitivities: base 80 mm, 20 mm high, 50 mm off the C axis in X and 50 mm above it.
inline TestPiece usual_piece(double half_angle_deg, double tilt_deg) {
  TestPiece piece;
  piece.cone = {.half_angle = Angle::degrees(half_angle_deg),
                .base_diameter = Length::millimetres(80),
                .height = Length::millimetres(20),
                .base_center_w_mm = {50, 0, 50},
                .tilt = Angle::degrees(tilt_deg)};
  piece.tool = {.diameter = Length::millimetres(20), .overhang = Length::millimetres(2)};
  piece.heights = {Length::millimetres(2), Length::millimetres(10), Length::millimetres(18)};
  return piece;
}

}  // namespace trunnion
