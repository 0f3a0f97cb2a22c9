#include "support/virtual_machine.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>

namespace trunnion::testing {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;

Isometry3d shift(const Vector3d& by_mm) { return Isometry3d(Eigen::Translation3d(by_mm)); }

Isometry3d about(const Vector3d& point_mm, const Isometry3d& motion) {
  return shift(point_mm) * motion * shift(-point_mm);
}

Isometry3d turn(const RotaryAxis& axis, double angle_rad) {
  return about(axis.origin_mm, Isometry3d(AngleAxisd(angle_rad, axis.direction.normalized())));
}

Isometry3d nominal_chain(const std::vector<RotaryAxis>& axes, const RotaryPosition& rotary) {
  Isometry3d chain = Isometry3d::Identity();
  for (const RotaryAxis& axis : axes) chain = chain * turn(axis, rotary.of(axis.name));
  return chain;
}

Isometry3d actual_chain(const VirtualMachine& machine, const std::vector<RotaryAxis>& axes, const MachineState& state) {
  Isometry3d chain = Isometry3d::Identity();
  for (const RotaryAxis& axis : axes) {
    if (axis.errors)
      chain = chain * about(axis.error_point_mm.value_or(axis.origin_mm), error_transform(axis.errors(state.rotary)));
    double angle = state.rotary.of(axis.name);
    for (const auto& [name, effect] : machine.joint_effects)
      if (name == axis.name) angle += effect(state);
    chain = chain * turn(axis, angle);
  }
  return chain;
}

Isometry3d applied(const std::vector<RigidEffect>& effects, const MachineState& state, Isometry3d placement) {
  for (const RigidEffect& effect : effects) placement = effect(state) * placement;
  return placement;
}

/// Tip against gauge point, nominally, with the tool-side axes turned.
Vector3d tip_from_gauge(const VirtualMachine& machine, const RotaryPosition& rotary, double tool_length_mm) {
  return nominal_chain(machine.tool_axes, rotary) * Vector3d(0, 0, -tool_length_mm);
}

double sense(double moved, double before) { return moved > 0 ? 1 : moved < 0 ? -1 : before; }

}  // namespace

AxisErrors um_urad(double ex, double ey, double ez, double ea, double eb, double ec) {
  return {Vector3d(ex, ey, ez) * 1e-3, Vector3d(ea, eb, ec) * 1e-6};
}

Isometry3d error_transform(const AxisErrors& errors) {
  const Vector3d& r = errors.rotation_rad;
  return Eigen::Translation3d(errors.translation_mm) * AngleAxisd(r.x(), Vector3d::UnitX()) *
         AngleAxisd(r.y(), Vector3d::UnitY()) * AngleAxisd(r.z(), Vector3d::UnitZ());
}

AxisErrors errors_of(const Isometry3d& motion) {
  // Rx(a) Ry(b) Rz(c): row 0 is (cos b cos c, -cos b sin c, sin b), column 2 is (sin b, -sin a cos b, cos a cos b).
  const Matrix3d m = motion.linear();
  return {motion.translation(),
          Vector3d(std::atan2(-m(1, 2), m(2, 2)), std::atan2(m(0, 2), std::hypot(m(0, 0), m(0, 1))),
                   std::atan2(-m(0, 1), m(0, 0)))};
}

double RotaryPosition::of(char axis) const { return axis == 'A' ? A_rad : axis == 'B' ? B_rad : C_rad; }

RotaryPosition ac_degrees(double A_deg, double C_deg) { return {A_deg * kDegree, 0, C_deg * kDegree}; }
RotaryPosition bc_degrees(double B_deg, double C_deg) { return {0, B_deg * kDegree, C_deg * kDegree}; }

double MachineState::covariate(const std::string& name) const {
  const auto found = covariates.find(name);
  return found == covariates.end() ? 0 : found->second;
}

const RotaryAxis& VirtualMachine::axis(char name) const {
  for (const auto* side : {&workpiece_axes, &tool_axes})
    for (const RotaryAxis& candidate : *side)
      if (candidate.name == name) return candidate;
  throw std::invalid_argument(std::string("the machine has no axis ") + name);
}

RotaryAxis& VirtualMachine::axis(char name) { return const_cast<RotaryAxis&>(std::as_const(*this).axis(name)); }

Isometry3d VirtualMachine::r_from_w(const MachineState& state) const {
  return applied(workpiece_effects, state, actual_chain(*this, workpiece_axes, state));
}

Isometry3d VirtualMachine::r_from_w_nominal(const RotaryPosition& rotary) const {
  return nominal_chain(workpiece_axes, rotary);
}

Isometry3d VirtualMachine::r_from_tool(const MachineState& state) const {
  const Vector3d gauge = state.tip_r_mm - tip_from_gauge(*this, state.rotary, state.tool_length_mm);
  const Vector3d tip(0, 0, -state.tool_length_mm);
  return applied(tool_effects, state, shift(gauge) * actual_chain(*this, tool_axes, state) * shift(tip));
}

Isometry3d VirtualMachine::r_from_tool_since_setup(const MachineState& state) const {
  const Vector3d tip(0, 0, -state.tool_length_mm);
  const Isometry3d head_at_setup = actual_chain(*this, tool_axes, MachineState{});
  const Matrix3d r_from_setup = (r_from_w(state) * r_from_w(MachineState{}).inverse()).linear();
  const Matrix3d w_from_tool_nominal =
      r_from_w_nominal(state.rotary).linear().transpose() * nominal_chain(tool_axes, state.rotary).linear();
  Isometry3d tool = r_from_tool(state);
  tool.translation() -= r_from_setup * (head_at_setup * tip - tip);
  tool.linear() =
      tool.linear() * w_from_tool_nominal.transpose() * head_at_setup.linear().transpose() * w_from_tool_nominal;
  return tool;
}

Isometry3d VirtualMachine::r_from_tool_nominal(const MachineState& state) const {
  Isometry3d placement = nominal_chain(tool_axes, state.rotary);
  placement.translation() = state.tip_r_mm;
  return placement;
}

Isometry3d VirtualMachine::table_error(const MachineState& state) const {
  return r_from_w(state) * r_from_w(MachineState{}).inverse() * r_from_w_nominal(state.rotary).inverse();
}

AxisErrors VirtualMachine::pose_error(const RotaryPosition& rotary) const {
  MachineState state;
  state.rotary = rotary;
  return errors_of(table_error(state));
}

Vector3d VirtualMachine::deviation_mm(const MachineState& state) const {
  return table_error(state) * state.tip_r_mm - r_from_tool_since_setup(state).translation();
}

Vector3d VirtualMachine::nominal_contact_r_mm(const Face& face, const RotaryPosition& rotary) const {
  return r_from_w_nominal(rotary) * face.nominal_w_mm;
}

Vector3d VirtualMachine::approach_r(const Face& face, const RotaryPosition& rotary) const {
  return -(r_from_w_nominal(rotary).linear() * face.nominal_outward_w);
}

Vector3d VirtualMachine::touch(const Face& face, MachineState state) const {
  const Vector3d n = approach_r(face, state.rotary);
  const Vector3d contact = nominal_contact_r_mm(face, state.rotary);
  for (int i = 0; i < 3; ++i) state.linear_sense[i] = std::abs(n[i]) < 1e-12 ? 0 : sense(n[i], 0);

  double travel = 0;  // of the commanded contact point along n, from where it is nominally
  TouchState triggered{state, face, n};
  for (int iteration = 0; iteration < 100; ++iteration) {
    triggered.machine.tip_r_mm = contact + (travel - ball_radius_mm) * n;
    Isometry3d r_from_face = r_from_w(triggered.machine);
    Isometry3d moved = Isometry3d::Identity();
    for (const ArtifactEffect& effect : artifact_effects) moved = effect(triggered) * moved;
    r_from_face = r_from_face * moved;
    const Vector3d outward = r_from_face.linear() * face.actual_outward_w;
    const Vector3d ball = r_from_tool(triggered.machine).translation();
    const double gap = outward.dot(ball - r_from_face * face.actual_w_mm) - ball_radius_mm;
    const double step = -gap / outward.dot(n);
    travel += step;
    if (std::abs(step) < 2e-14) break;
  }
  for (const ReadingEffect& effect : reading_effects) travel += effect(triggered);
  return contact + travel * n;
}

double VirtualMachine::displacement_mm(const Vector3d& ball_w_mm, const Vector3d& n, const MachineState& state) const {
  return n.dot(r_from_w(state) * ball_w_mm - r_from_tool(state).translation());
}

double VirtualMachine::rotation_rad(const Vector3d& about_axis, const MachineState& state) const {
  const AngleAxisd error(table_error(state).linear());
  return about_axis.dot(error.angle() * error.axis());
}

Isometry3d VirtualMachine::pose(const Isometry3d& instrument_from_r, const Isometry3d& w_from_target,
                                const MachineState& state) const {
  return instrument_from_r * r_from_w(state) * w_from_target;
}

MachineState VirtualMachine::commanded_state(const Command& command) const {
  MachineState state;
  state.rotary = command.rotary;
  state.tool_length_mm = command.tool_length_mm;
  state.time_s = command.time_s;
  state.temperature_C = command.temperature_C;
  state.covariates = command.covariates;
  const Vector3d programmed = command.xyz_mm + command.offset_mm;
  if (command.tcp == Tcp::on) {
    state.tip_r_mm = r_from_w_nominal(command.rotary) * programmed;
  } else {
    const Vector3d gauge = programmed + Vector3d(0, 0, command.tool_length_mm);
    state.tip_r_mm = gauge + tip_from_gauge(*this, command.rotary, command.tool_length_mm);
  }
  return state;
}

ToolInWorkpiece VirtualMachine::tool_in_workpiece(const MachineState& state) const {
  const Isometry3d w_from_r = (r_from_w(state) * r_from_w(MachineState{}).inverse()).inverse();
  const Isometry3d tool = r_from_tool_since_setup(state);
  return {w_from_r * tool.translation(), w_from_r.linear() * tool.linear().col(2)};
}

std::vector<ToolInWorkpiece> VirtualMachine::play(const std::vector<Command>& program) const {
  std::vector<ToolInWorkpiece> path;
  MachineState before;
  Vector3d gauge_before = Vector3d::Zero();
  for (const Command& command : program) {
    MachineState state = commanded_state(command);
    const Vector3d gauge = state.tip_r_mm - tip_from_gauge(*this, state.rotary, state.tool_length_mm);
    if (!path.empty()) {
      state.rotary_sense = {sense(state.rotary.A_rad - before.rotary.A_rad, before.rotary_sense.A_rad),
                            sense(state.rotary.B_rad - before.rotary.B_rad, before.rotary_sense.B_rad),
                            sense(state.rotary.C_rad - before.rotary.C_rad, before.rotary_sense.C_rad)};
      for (int i = 0; i < 3; ++i) state.linear_sense[i] = sense(gauge[i] - gauge_before[i], before.linear_sense[i]);
    }
    path.push_back(tool_in_workpiece(state));
    before = state;
    gauge_before = gauge;
  }
  return path;
}

Command between(const Command& from, const Command& to, double fraction) {
  const auto mix = [fraction](double a, double b) { return a + fraction * (b - a); };
  Command command = to;
  command.xyz_mm = from.xyz_mm + fraction * (to.xyz_mm - from.xyz_mm);
  command.rotary = {mix(from.rotary.A_rad, to.rotary.A_rad), mix(from.rotary.B_rad, to.rotary.B_rad),
                    mix(from.rotary.C_rad, to.rotary.C_rad)};
  command.time_s = mix(from.time_s, to.time_s);
  command.temperature_C = mix(from.temperature_C, to.temperature_C);
  return command;
}

VirtualMachine perfect_machine(const std::string& structure) {
  const auto refuse = [&structure](const std::string& why) {
    throw std::invalid_argument("structure \"" + structure + "\": " + why);
  };
  std::istringstream words(structure);
  std::vector<std::string> code;
  for (std::string word; words >> word;) code.push_back(word);
  const auto bed = std::find(code.begin(), code.end(), "b");
  if (code.size() < 3 || code.front() != "w" || code.back() != "t" || bed == code.end())
    refuse("wanted w ... b ... t, from workpiece to tool");

  VirtualMachine machine;
  const auto add = [&](std::string word, Side side, bool& rotary_seen) {
    if (!word.empty() && word.back() == '\'') {
      if (side == Side::tool) refuse(word + " is primed on the tool side");
      word.pop_back();
    }
    const std::size_t index = word.size() == 1 ? std::string("XYZABC").find(word) : std::string::npos;
    if (index == std::string::npos) refuse("unknown axis " + word);
    if (index < 3 && rotary_seen) refuse("linear axis " + word + " is carried by a rotary axis");
    if (index < 3) return;
    rotary_seen = true;
    RotaryAxis axis;
    axis.name = word[0];
    axis.side = side;
    axis.direction = Vector3d::Unit(static_cast<Eigen::Index>(index) - 3);
    (side == Side::workpiece ? machine.workpiece_axes : machine.tool_axes).push_back(axis);
  };
  bool rotary_seen = false;
  for (auto word = bed; word-- != code.begin() + 1;) add(*word, Side::workpiece, rotary_seen);
  rotary_seen = false;
  for (auto word = bed + 1; word != code.end() - 1; ++word) add(*word, Side::tool, rotary_seen);
  return machine;
}

}  // namespace trunnion::testing
