#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/effects/rotary_error_map.h"
#include "model/model.h"
#include "support/replica.h"
#include "support/smooth_machine.h"

// Machines of the program's own kind made from the virtual machine of the tests: its maps as a perfect measurement
// gives them, on a grid.

namespace trunnion::compensation_test {

inline Machine trunnion_machine(const std::string& controller = "linuxcnc") {
  Machine machine;
  machine.name = "Trunnion of the tests";
  machine.serial = "0042";
  machine.structure = parse_structure("w C' A' Y' b X Z t");
  machine.axes = default_axes(machine.structure);
  machine.axes.at('A').range_angle = Range<Angle>{Angle::degrees(-120), Angle::degrees(30)};
  machine.controller = controller;
  machine.work_volume.a = Range<Angle>{Angle::degrees(-90), Angle::degrees(0)};
  return machine;
}

inline PoseError pose_error_of(const testing::AxisErrors& e) { return {e.translation_mm, e.rotation_rad}; }

/// A map through the virtual machine's errors every 15 deg of A and every `turn_step_deg` of C.
inline Model model_of(const testing::VirtualMachine& virtual_machine, const Machine& machine,
                      double turn_step_deg = 30) {
  std::vector<double> a_deg, c_deg;
  for (double a = -90; a <= 0; a += 15) a_deg.push_back(a);
  for (double c = 0; c < 360 - 1e-9; c += turn_step_deg) c_deg.push_back(c);
  const testing::GaugedMaps maps = testing::gauged_maps(virtual_machine, a_deg, c_deg);
  RotaryMapContent content;
  for (const double a : a_deg) content.grid.a_stations.push_back(Angle::degrees(a));
  for (const double c : c_deg) content.grid.c_stations.push_back(Angle::degrees(c));
  for (const auto& e : maps.tilt) content.grid.tilt.push_back(pose_error_of(e));
  for (const auto& e : maps.C) content.grid.turn.push_back(pose_error_of(e));
  Model model;
  model.machine = {machine.name, machine.serial, machine.structure.code};
  model.effects.push_back(std::make_shared<RotaryErrorMap>(std::move(content), effect_context(machine)));
  return model;
}

inline Model replica_model(const Machine& machine) { return model_of(testing::replica_machine(), machine); }
inline Model random_model(const Machine& machine, std::uint64_t seed) {
  return model_of(testing::smooth_machine(seed), machine);
}

/// Adds an effect of the catalogue with one parameter.
inline void add_effect(Model& model, const Machine& machine, const std::string& id, const std::string& parameter,
                       double value, const std::string& unit) {
  const nlohmann::json json = {{"id", id}, {"parameters", {{parameter, {{"value", value}, {"unit", unit}}}}}};
  model.effects.push_back(read_effect(json, effect_context(machine)));
}

/// Adds a map of its own: C stands wrong by cos(6 C) - 1, times 6 urad, at every tilt.
inline void add_cyclic_error(Model& model, const Machine& machine, double amplitude_urad) {
  RotaryMapContent content;
  for (const double a : {-90.0, 0.0}) content.grid.a_stations.push_back(Angle::degrees(a));
  for (double c = 0; c < 360; c += 15) content.grid.c_stations.push_back(Angle::degrees(c));
  content.grid.tilt.resize(2);
  for (int i = 0; i < 2; ++i)
    for (const Angle c : content.grid.c_stations)
      content.grid.turn.push_back({.rotation_rad = {0, 0, amplitude_urad * 1e-6 * std::cos(6 * c.in_radians())}});
  model.effects.push_back(std::make_shared<RotaryErrorMap>(std::move(content), effect_context(machine)));
}

}  // namespace trunnion::compensation_test
