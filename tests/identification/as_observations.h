#pragma once

#include <algorithm>
#include <map>
#include <vector>

#include "kinematics/machine.h"
#include "probing/observation.h"
#include "support/observation_row.h"

namespace trunnion::testing {

/// The rows of the virtual machine as the program holds them after reading a file.
inline ObservationSet as_observations(const std::vector<ObservationRow>& rows,
                                      const std::string& name = "virtual.csv") {
  ObservationSet set{.files = {name}};
  std::map<std::string, std::uint32_t> points, artifacts;
  const auto intern = [](std::map<std::string, std::uint32_t>& known, std::vector<std::string>& labels,
                         const std::string& label) {
    const auto [entry, added] = known.emplace(label, static_cast<std::uint32_t>(labels.size()));
    if (added) labels.push_back(label);
    return entry->second;
  };
  if (!rows.empty())
    for (const auto& [column, value] : rows.front().covariates) set.extra_columns.push_back(column), (void)value;
  std::uint32_t line = 1;
  for (const ObservationRow& row : rows) {
    Observation o;
    o.kind = row.kind == "contact"        ? ReadingKind::contact
             : row.kind == "displacement" ? ReadingKind::displacement
             : row.kind == "rotation"     ? ReadingKind::rotation
                                          : ReadingKind::pose;
    o.line = ++line;
    o.at = {Angle::degrees(row.A_deg), Angle::degrees(row.C_deg)};
    o.point = intern(points, set.points, row.point);
    o.artifact = intern(artifacts, set.artifacts, row.artifact);
    if (row.xyz_mm) o.position_mm = *row.xyz_mm;
    if (row.n) o.direction = *row.n;
    if (row.m) o.direction = *row.m;
    if (row.value_um) o.value = *row.value_um * 1e-3;
    if (row.value_urad) o.value = *row.value_urad * 1e-6;
    if (row.quaternion_wxyz) {
      const Eigen::Vector4d& q = *row.quaternion_wxyz;
      o.orientation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
    }
    o.repeat = row.repeat.value_or(0);
    o.time_s = row.time_s.value_or(0);
    o.tilt_sense = row.A_dir.value_or(1);
    o.turn_sense = row.C_dir.value_or(1);
    o.temperature_C = row.temperature_C.value_or(20);
    o.sigma = row.sigma_um.value_or(0) * 1e-3;
    set.has_time = set.has_time || row.time_s;
    set.has_temperature = set.has_temperature || row.temperature_C;
    set.has_tilt_sense = set.has_tilt_sense || row.A_dir;
    set.has_turn_sense = set.has_turn_sense || row.C_dir;
    set.has_repeat = set.has_repeat || row.repeat;
    set.has_sigma = set.has_sigma || row.sigma_um;
    for (const std::string& column : set.extra_columns) set.extra_values.push_back(row.covariates.at(column));
    set.rows.push_back(o);
  }
  return set;
}

/// The machine of the sample calibration: axes through R's origin, `sigma_um` one touch.
inline Machine plain_machine(const std::string& structure = "w C' A' Y' b X Z t", double sigma_um = 0.175) {
  Machine machine{.name = "virtual", .serial = "0", .structure = parse_structure(structure)};
  machine.axes = default_axes(machine.structure);
  machine.probe.sigma = Length::micrometres(sigma_um);
  return machine;
}

}  // namespace trunnion::testing
