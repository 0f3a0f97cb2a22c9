#pragma once

#include <cmath>

#include "support/brute_force_cut.h"
#include "testpiece/machining.h"
#include "units/angle.h"

namespace trunnion {

/// What the machines of tests/support are told of one position of a path.
inline testing::MachineState state_of(const ToolPosition& p, const TestPiece& piece) {
  testing::MachineState state{.rotary = testing::ac_degrees(p.at.a.in_degrees(), p.at.c.in_degrees()),
                              .tip_r_mm = p.tip_r_mm,
                              .tool_length_mm = piece.tool.length.in_millimetres(),
                              .time_s = p.time_s};
  state.rotary_sense.A_rad = p.tilt_sense;
  state.rotary_sense.C_rad = p.turn_sense;
  state.linear_sense = p.linear_sense;
  return state;
}

/// What an exact machine leaves on every evaluated point, position by position; it takes the path's commands and
/// nothing else of the code under test. `prepare` completes a state: temperature, covariates.
template <class Prepare>
std::vector<double> cut_by_brute_force(const testing::VirtualMachine& machine, const TestPiece& piece,
                                       const SurfaceGrid& surface, const std::vector<ToolPosition>& path,
                                       Prepare prepare) {
  std::vector<testing::ToolInWorkpiece> tools;
  for (const ToolPosition& p : path) {
    testing::MachineState state = state_of(p, piece);
    prepare(state);
    tools.push_back(machine.tool_in_workpiece(state));
  }
  const testing::Cutter cutter{0.5 * piece.tool.diameter.in_millimetres(), piece.tool.corner_radius.in_millimetres()};
  std::vector<double> left;
  // Only positions within 6 deg of a point can matter to it; those far away cut elsewhere or not yet.
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    const double phi = surface.phi_rad[i % surface.phi_rad.size()];
    std::vector<testing::ToolInWorkpiece> near;
    for (std::size_t j = 0; j < tools.size(); ++j)
      if (std::abs(std::remainder(path[j].phi_rad - phi, kTurn_rad)) < kTurn_rad / 60) near.push_back(tools[j]);
    left.push_back(testing::material_left_mm(cutter, near, surface.points[i].point_w_mm, surface.points[i].normal_w));
  }
  return left;
}
inline std::vector<double> cut_by_brute_force(const testing::VirtualMachine& machine, const TestPiece& piece,
                                              const SurfaceGrid& surface, const std::vector<ToolPosition>& path) {
  return cut_by_brute_force(machine, piece, surface, path, [](testing::MachineState&) {});
}

}  // namespace trunnion
