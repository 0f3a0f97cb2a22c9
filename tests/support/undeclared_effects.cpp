#include "support/undeclared_effects.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace trunnion::testing {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;

int index_of(char letter, const std::string& letters) {
  const std::size_t index = letters.find(letter);
  if (index == std::string::npos) throw std::invalid_argument(std::string("wanted one of ") + letters + ": " + letter);
  return static_cast<int>(index);
}

int linear(char axis) { return index_of(axis, "XYZ"); }

/// The tool stands off by `amount(state)` along a direction of R, so d is minus that.
void move_tool(VirtualMachine& machine, int direction, std::function<double(const MachineState&)> amount_mm) {
  machine.tool_effects.push_back(
      [direction, amount_mm = std::move(amount_mm)](const MachineState& state) -> Isometry3d {
        return Isometry3d(Translation3d(amount_mm(state) * Vector3d::Unit(direction)));
      });
}

AxisErrors scaled(double factor, const AxisErrors& errors) {
  return {factor * errors.translation_mm, factor * errors.rotation_rad};
}

Isometry3d turned(int direction, double angle_rad, const Vector3d& about_mm) {
  return Translation3d(about_mm) * AngleAxisd(angle_rad, Vector3d::Unit(direction)) * Translation3d(-about_mm);
}

struct Symbol {
  int direction;
  int axis;
};
Symbol parsed(const std::string& symbol, const std::string& directions) {
  if (symbol.size() != 3 || symbol[0] != 'E') throw std::invalid_argument("not a component error: " + symbol);
  return {index_of(symbol[1], directions), linear(symbol[2])};
}

}  // namespace

void add_linear_scale(VirtualMachine& machine, char axis, double scale) {
  const int i = linear(axis);
  move_tool(machine, i, [i, scale](const MachineState& state) { return scale * state.tip_r_mm[i]; });
}

void add_squareness(VirtualMachine& machine, const std::string& plane, double angle_rad) {
  if (plane != "XY" && plane != "XZ" && plane != "YZ") throw std::invalid_argument("wanted XY, XZ or YZ: " + plane);
  const int moved = linear(plane[0]);
  const int along = linear(plane[1]);
  const double slope = plane == "YZ" ? -angle_rad : angle_rad;
  move_tool(machine, moved, [along, slope](const MachineState& state) { return slope * state.tip_r_mm[along]; });
}

void add_straightness(VirtualMachine& machine, const std::string& symbol, std::function<double(double)> mm_at_mm) {
  const Symbol s = parsed(symbol, "XYZ");
  move_tool(machine, s.direction,
            [s, f = std::move(mm_at_mm)](const MachineState& state) { return f(state.tip_r_mm[s.axis]); });
}

void add_table_angular(VirtualMachine& machine, const std::string& symbol, std::function<double(double)> rad_at_mm,
                       const Vector3d& point_r_mm) {
  const Symbol s = parsed(symbol, "ABC");
  machine.workpiece_effects.push_back([s, point_r_mm, f = std::move(rad_at_mm)](const MachineState& state) {
    return turned(s.direction, f(state.tip_r_mm[s.axis]), point_r_mm);
  });
}

void add_tool_angular(VirtualMachine& machine, const std::string& symbol, std::function<double(double)> rad_at_mm) {
  const Symbol s = parsed(symbol, "ABC");
  machine.tool_effects.push_back([s, f = std::move(rad_at_mm)](const MachineState& state) {
    const Vector3d gauge = state.tip_r_mm + Vector3d(0, 0, state.tool_length_mm);
    return turned(s.direction, f(state.tip_r_mm[s.axis]), gauge);
  });
}

void add_linear_periodic(VirtualMachine& machine, char axis, double amplitude_mm, double period_mm, double phase_rad) {
  const int i = linear(axis);
  move_tool(machine, i, [=](const MachineState& state) {
    return amplitude_mm * std::cos(2 * std::numbers::pi * state.tip_r_mm[i] / period_mm + phase_rad);
  });
}

void add_linear_backlash(VirtualMachine& machine, char axis, double width_mm) {
  const int i = linear(axis);
  move_tool(machine, i, [=](const MachineState& state) { return -width_mm / 2 * state.linear_sense[i]; });
}

void add_rotary_backlash(VirtualMachine& machine, char axis, double width_rad) {
  machine.joint_effects.emplace_back(
      axis, [=](const MachineState& state) { return width_rad / 2 * (state.rotary_sense.of(axis) - 1); });
}

void add_cyclic_error(VirtualMachine& machine, char axis, int cycles, double cos_rad, double sin_rad) {
  machine.joint_effects.emplace_back(axis, [=](const MachineState& state) {
    const double angle = cycles * state.rotary.of(axis);
    return cos_rad * std::cos(angle) + sin_rad * std::sin(angle);
  });
}

void add_brake_clamp(VirtualMachine& machine, char axis, const std::string& covariate, double step_rad) {
  machine.joint_effects.emplace_back(axis,
                                     [=](const MachineState& state) { return step_rad * state.covariate(covariate); });
}

void add_payload_sag(VirtualMachine& machine, const std::string& covariate, double constant_rad, double rad_per_unit,
                     double phase_rad) {
  machine.workpiece_effects.push_back([=](const MachineState& state) {
    const double reach = constant_rad + rad_per_unit * state.covariate(covariate);
    return turned(0, reach * std::sin(state.rotary.A_rad + phase_rad), Vector3d::Zero());
  });
}

void add_drift(VirtualMachine& machine, std::function<AxisErrors(double)> motion_at_s) {
  machine.workpiece_effects.push_back(
      [motion = std::move(motion_at_s)](const MachineState& state) { return error_transform(motion(state.time_s)); });
}

void add_thermal_drift(VirtualMachine& machine, const AxisErrors& end, double time_constant_s) {
  add_drift(machine, [=](double time_s) { return scaled(-std::expm1(-time_s / time_constant_s), end); });
}

void add_temperature(VirtualMachine& machine, const AxisErrors& per_kelvin) {
  machine.workpiece_effects.push_back([per_kelvin](const MachineState& state) {
    return error_transform(scaled(state.temperature_C - 20, per_kelvin));
  });
}

void add_probe_lobing(VirtualMachine& machine, int lobes, double cos_mm, double sin_mm) {
  machine.reading_effects.push_back([=](const TouchState& touch) {
    const Vector3d& n = touch.approach_r;
    const double angle = lobes * std::atan2(n.y(), n.x());
    return (1 - n.z() * n.z()) * (cos_mm * std::cos(angle) + sin_mm * std::sin(angle));
  });
}

void add_probe_pretravel(VirtualMachine& machine, double axial_mm) {
  machine.reading_effects.push_back(
      [=](const TouchState& touch) { return axial_mm * touch.approach_r.z() * touch.approach_r.z(); });
}

void add_first_touches(VirtualMachine& machine, const Vector3d& start_mm, double decay_touches) {
  machine.reading_effects.push_back([=](const TouchState& touch) {
    return touch.approach_r.dot(start_mm) * std::exp(-touch.machine.order / decay_touches);
  });
}

void add_settling(VirtualMachine& machine, const Vector3d& per_touch_mm) {
  machine.reading_effects.push_back(
      [=](const TouchState& touch) { return touch.approach_r.dot(per_touch_mm) * touch.machine.order_in_pose; });
}

void add_artifact_expansion(VirtualMachine& machine, double per_kelvin,
                            std::function<double(const MachineState&)> kelvin, const Vector3d& fixed_w_mm) {
  machine.artifact_effects.push_back([=](const TouchState& touch) -> Isometry3d {
    const Vector3d grown = per_kelvin * kelvin(touch.machine) * (touch.face.actual_w_mm - fixed_w_mm);
    return Isometry3d(Translation3d(grown));
  });
}

void add_artifact_slip(VirtualMachine& machine, const std::string& artifact, const AxisErrors& moved_w,
                       int from_order) {
  machine.artifact_effects.push_back([=](const TouchState& touch) -> Isometry3d {
    const bool slipped = touch.face.artifact == artifact && touch.machine.order >= from_order;
    return slipped ? error_transform(moved_w) : Isometry3d::Identity();
  });
}

void add_artifact_creep(VirtualMachine& machine, const std::string& artifact, const Vector3d& end_w_mm,
                        double time_constant_s) {
  machine.artifact_effects.push_back([=](const TouchState& touch) -> Isometry3d {
    if (touch.face.artifact != artifact) return Isometry3d::Identity();
    return Isometry3d(Translation3d(-std::expm1(-touch.machine.time_s / time_constant_s) * end_w_mm));
  });
}

void add_pass_shift(VirtualMachine& machine, int repeat, const Vector3d& shift_r_mm) {
  machine.reading_effects.push_back(
      [=](const TouchState& touch) { return touch.machine.repeat == repeat ? touch.approach_r.dot(shift_r_mm) : 0.0; });
}

}  // namespace trunnion::testing
