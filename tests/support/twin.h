#pragma once

#include <map>
#include <string>

#include "geometric_errors/rotary_errors.h"
#include "support/virtual_machine.h"

namespace trunnion {

/// Where an axis line runs.
struct AxisPlace {
  Eigen::Vector3d direction;
  Eigen::Vector3d origin_mm = Eigen::Vector3d::Zero();
};

/// One machine told twice: as the program takes it, and as the exact machine that judges the program.
struct Twin {
  Machine machine;
  testing::VirtualMachine exact;
};

inline Twin twin(const std::string& structure, const std::map<char, AxisPlace>& places = {}) {
  Twin both{.machine = {.name = "twin", .serial = "1", .structure = parse_structure(structure)},
            .exact = testing::perfect_machine(structure)};
  both.machine.axes = default_axes(both.machine.structure);
  for (const auto& [letter, place] : places) {
    both.machine.axes.at(letter).direction = place.direction;
    both.machine.axes.at(letter).origin_mm = place.origin_mm;
    both.exact.axis(letter).direction = place.direction;
    both.exact.axis(letter).origin_mm = place.origin_mm;
  }
  return both;
}

inline testing::RotaryPosition exact_position(const Machine& machine, IndexedPosition at) {
  const double a = at.a.in_radians(), c = at.c.in_radians();
  return machine.tilt_letter() == 'A' ? testing::RotaryPosition{.A_rad = a, .C_rad = c}
                                      : testing::RotaryPosition{.B_rad = a, .C_rad = c};
}

inline testing::MachineState exact_state(const Machine& machine, IndexedPosition at, const Eigen::Vector3d& tip_r_mm,
                                         double tool_length_mm = 0) {
  testing::MachineState state;
  state.rotary = exact_position(machine, at);
  state.tip_r_mm = tip_r_mm;
  state.tool_length_mm = tool_length_mm;
  return state;
}

inline testing::AxisErrors exact_errors(const PoseError& error) { return {error.translation_mm, error.rotation_rad}; }

/// The exact machine shall have the errors `field(a, c)` says.
template <class Field>
void give_errors(Twin& both, Field field) {
  const char tilt = both.machine.tilt_letter();
  const auto at = [tilt](const testing::RotaryPosition& q) {
    return IndexedPosition{Angle::radians(q.of(tilt)), Angle::radians(q.C_rad)};
  };
  both.exact.axis(tilt).errors = [=](const testing::RotaryPosition& q) { return exact_errors(field(at(q)).tilt); };
  both.exact.axis('C').errors = [=](const testing::RotaryPosition& q) { return exact_errors(field(at(q)).turn); };
}

inline Eigen::Matrix<double, 12, 1> stacked(const RotaryErrors& errors) {
  return (Eigen::Matrix<double, 12, 1>() << errors.tilt.vector(), errors.turn.vector()).finished();
}

/// (um; urad).
inline PoseError um_urad(double x, double y, double z, double a, double b, double c) {
  return {1e-3 * Eigen::Vector3d(x, y, z), 1e-6 * Eigen::Vector3d(a, b, c)};
}

inline IndexedPosition degrees(double a, double c) { return {Angle::degrees(a), Angle::degrees(c)}; }

/// Machines of every kind that the program knows, reversed senses and axes that do not cross among them.
inline std::map<std::string, Twin> twins() {
  using V = Eigen::Vector3d;
  return {
      {"crossing", twin("w C' A' Y' b X Z t")},
      {"not crossing",
       twin("w C' A' Y' b X Z t", {{'A', {V::UnitX(), {0, 12, -50}}}, {'C', {V::UnitZ(), {3, 58, 0}}}})},
      {"reversed", twin("w C' A' b X Y Z t", {{'A', {-V::UnitX(), {1, 2, 3}}}, {'C', {-V::UnitZ(), {-4, 5, -6}}}})},
      {"B trunnion", twin("w C' B' X' b Y Z t", {{'B', {V::UnitY(), {0, 0, 25}}}, {'C', {V::UnitZ(), {-9, 0, 0}}}})},
      {"nutating", twin("w C' B' X' b Y Z t", {{'B', {V(0, 1, 1).normalized(), {0, 10, 0}}}})},
      {"turn carries tilt",
       twin("w A' C' Y' b X Z t", {{'A', {V::UnitX(), {0, 5, 20}}}, {'C', {V::UnitZ(), {7, 0, 0}}}})},
      {"head and table",
       twin("w C' X' b Y Z B t", {{'B', {V::UnitY(), {2, 0, 150}}}, {'C', {V::UnitZ(), {30, -20, 0}}}})},
      {"head C, table A", twin("w A' X' b Y Z C t", {{'A', {V::UnitX(), {0, 3, 40}}}, {'C', {V::UnitZ(), {1, 2, 0}}}})},
      {"fork head", twin("w X' b Y Z C A t", {{'A', {V::UnitX(), {0, 4, 180}}}, {'C', {V::UnitZ(), {1, -2, 0}}}})}};
}

}  // namespace trunnion
