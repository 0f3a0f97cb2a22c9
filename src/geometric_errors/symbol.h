#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "units/unit.h"

namespace trunnion {

/// Signs, told once. A component error after ISO 230-1/-7: E, then the direction of the error (X Y Z: translation along
/// R's axes, A B C: right-handed rotation about them), then the axis that moves. A symbol keeps its right-handed sense
/// about R's axes whatever the machine file's `direction` says. Order of components everywhere: X, Y, Z, A, B, C.
inline constexpr std::string_view kComponentLetters = "XYZABC";

/// `EXC`: component 0..5 of the error motion of axis 'C'.
std::string error_symbol(std::size_t component, char axis);

/// Lengths are kept in um in files, rotations in urad.
constexpr Unit component_unit(std::size_t component) { return component < 3 ? Unit::um : Unit::urad; }

/// The eight location errors that a tilting rotary table shows (ISO 230-1; `axis` is the tilting axis A or B), as
/// the errors of that axis (tilting or turning) which stay constant. Constants of the other four kinds move nothing
/// or are absorbed in the workpiece datum.
struct LocationError {
  std::string symbol;     ///< e.g. EY0A, EX0C
  bool of_turning_axis;   ///< C's, else the tilting axis'
  std::size_t component;  ///< 0..5
};
std::array<LocationError, 8> location_errors(char tilt_letter);

}  // namespace trunnion
