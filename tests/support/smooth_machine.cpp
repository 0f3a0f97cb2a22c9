#include "support/smooth_machine.h"

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include "support/undeclared_effects.h"

namespace trunnion::testing {
namespace {

using Eigen::Vector3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kDegree = std::numbers::pi / 180;

char tilt_letter(const VirtualMachine& machine) {
  for (const auto* side : {&machine.workpiece_axes, &machine.tool_axes})
    for (const RotaryAxis& axis : *side)
      if (axis.name != 'C') return axis.name;
  throw std::invalid_argument("the machine has no tilting axis");
}

AxisErrors errors_from(const Vector6& six) { return {six.head<3>(), six.tail<3>()}; }

Vector6 drawn(Noise& noise, double translation_mm, double rotation_rad) {
  Vector6 six;
  for (int i = 0; i < 6; ++i) six[i] = noise.normal() * (i < 3 ? translation_mm : rotation_rad);
  return six;
}

/// Coefficients of one harmonic's cosine or sine, as they vary with the tilt.
using TiltMix = std::array<Vector6, 3>;
Vector6 at_tilt(const TiltMix& mix, double tilt) { return mix[0] + mix[1] * std::sin(tilt) + mix[2] * std::cos(tilt); }

double random_sign(Noise& noise) { return noise.bits() & 1U ? 1 : -1; }

/// Away from zero, so that it can be found: between `size` and 2 `size`, either sign.
double sized(Noise& noise, double size) { return random_sign(noise) * size * noise.uniform(1, 2); }

using Adder = void (*)(VirtualMachine&, Noise&, double, int);

const std::map<std::string, Adder>& adders() {
  using M = VirtualMachine;
  using N = Noise;
  static const std::map<std::string, Adder> all = {
      {"linear_scale:X", [](M& m, N& n, double, int) { add_linear_scale(m, 'X', sized(n, 8e-6)); }},
      {"linear_scale:Y", [](M& m, N& n, double, int) { add_linear_scale(m, 'Y', sized(n, 8e-6)); }},
      {"linear_scale:Z", [](M& m, N& n, double, int) { add_linear_scale(m, 'Z', sized(n, 8e-6)); }},
      {"squareness:XY", [](M& m, N& n, double, int) { add_squareness(m, "XY", sized(n, 8e-6)); }},
      {"squareness:XZ", [](M& m, N& n, double, int) { add_squareness(m, "XZ", sized(n, 8e-6)); }},
      {"squareness:YZ", [](M& m, N& n, double, int) { add_squareness(m, "YZ", sized(n, 15e-6)); }},
      {"straightness:EZX",
       [](M& m, N& n, double, int) {
         add_straightness(m, "EZX", [k = sized(n, 2e-3)](double x) { return k * x * x / 1e4; });
       }},
      {"straightness:EYX",
       [](M& m, N& n, double, int) {
         add_straightness(m, "EYX", [k = sized(n, 2e-3)](double x) { return k * x * x / 1e4; });
       }},
      {"linear_angular:ECY",
       [](M& m, N& n, double, int) {
         add_table_angular(m, "ECY", [k = sized(n, 10e-6)](double y) { return k * y / 100; });
       }},
      {"linear_periodic:Y",
       [](M& m, N& n, double, int) {
         const double amplitude_mm = n.uniform(.5e-3, 1e-3), phase_rad = n.uniform(0, 2 * std::numbers::pi);
         add_linear_periodic(m, 'Y', amplitude_mm, 10, phase_rad);
       }},
      {"linear_backlash:X", [](M& m, N& n, double, int) { add_linear_backlash(m, 'X', n.uniform(1e-3, 3e-3)); }},
      {"backlash:A", [](M& m, N& n, double, int) { add_rotary_backlash(m, 'A', sized(n, 8e-6)); }},
      {"backlash:C", [](M& m, N& n, double, int) { add_rotary_backlash(m, 'C', sized(n, 8e-6)); }},
      {"cyclic_error:C:6",
       [](M& m, N& n, double, int) {
         const double a = sized(n, 8e-6), b = sized(n, 8e-6);
         add_cyclic_error(m, 'C', 6, a, b);
       }},
      {"thermal_drift",
       [](M& m, N& n, double duration_s, int) {
         const double y_um = sized(n, 2), z_um = sized(n, 3);
         add_thermal_drift(m, um_urad(0, y_um, z_um, 0, 0, 0), duration_s / n.uniform(4, 8));
       }},
      {"temperature", [](M& m, N& n, double, int) { add_temperature(m, um_urad(0, 0, sized(n, 3), 0, 0, 0)); }},
      {"probe_lobing:3",
       [](M& m, N& n, double, int) {
         const double a = sized(n, .3e-3), b = sized(n, .3e-3);
         add_probe_lobing(m, 3, a, b);
       }},
      {"probe_pretravel", [](M& m, N& n, double, int) { add_probe_pretravel(m, sized(n, 1.5e-3)); }},
      {"artifact_expansion",
       [](M& m, N& n, double duration_s, int) {
         const double kelvin = sized(n, .5);
         add_artifact_expansion(m, 23.8e-6, [=](const MachineState& s) { return kelvin * s.time_s / duration_s; });
       }},
      {"artifact_slip:2",
       [](M& m, N& n, double, int touches) {
         const double x = sized(n, 1.5), y = sized(n, 1.5);
         const int from = touches / 4 + static_cast<int>(n.below(static_cast<std::uint64_t>(touches) / 2));
         add_artifact_slip(m, "2", um_urad(x, y, 0, 0, 0, 0), from);
       }},
      {"artifact_creep",
       [](M& m, N& n, double duration_s, int) {
         const double x = sized(n, 1.5e-3), y = sized(n, 1.5e-3);
         add_artifact_creep(m, "1", {x, y, 0}, duration_s / 4);
       }},
      {"pass_shift",
       [](M& m, N& n, double, int) {
         const double x = sized(n, 1e-3), z = sized(n, 1e-3);
         add_pass_shift(m, 1, {x, 0, z});
       }},
  };
  return all;
}

}  // namespace

VirtualMachine smooth_machine(std::uint64_t seed, const SmoothMachineOptions& options, const std::string& structure) {
  Noise noise(seed);
  VirtualMachine machine = perfect_machine(structure);
  const char letter = tilt_letter(machine);

  Vector6 tilt_constant = drawn(noise, options.location_mm, options.location_rad);
  Vector6 C_constant = drawn(noise, options.location_mm, options.location_rad);
  // Of the tilting axis the shift along it and its zero are no location errors, of C the shift along it and its zero.
  const int along = letter == 'A' ? 0 : 1;
  tilt_constant[along] = tilt_constant[3 + along] = 0;
  C_constant[2] = C_constant[5] = 0;

  std::array<Vector6, 3> motion;
  for (Vector6& part : motion) part = drawn(noise, options.translation_mm, options.rotation_rad);
  machine.axis(letter).errors = [=](const RotaryPosition& q) {
    const double t = q.of(letter);
    return errors_from(tilt_constant + motion[0] * std::sin(t) + motion[1] * (1 - std::cos(t)) +
                       motion[2] * std::sin(2 * t));
  };

  std::vector<std::pair<TiltMix, TiltMix>> harmonics;
  for (int h = 1; h <= options.C_harmonics; ++h) {
    auto& [cosine, sine] = harmonics.emplace_back();
    for (TiltMix* mix : {&cosine, &sine})
      for (Vector6& part : *mix) part = drawn(noise, options.translation_mm / h, options.rotation_rad / h);
  }
  machine.axis('C').errors = [=](const RotaryPosition& q) {
    Vector6 six = C_constant;
    for (std::size_t i = 0; i < harmonics.size(); ++i) {
      const double angle = static_cast<double>(i + 1) * q.C_rad;
      six += at_tilt(harmonics[i].first, q.of(letter)) * std::cos(angle) +
             at_tilt(harmonics[i].second, q.of(letter)) * std::sin(angle);
    }
    return errors_from(six);
  };
  return machine;
}

VirtualMachine location_errors_only(std::uint64_t seed, const std::string& structure) {
  return smooth_machine(seed, {.translation_mm = 0, .rotation_rad = 0}, structure);
}

std::vector<std::string> undeclared_ids() {
  std::vector<std::string> ids;
  for (const auto& [id, adder] : adders()) ids.push_back(id);
  return ids;
}

void add_undeclared(VirtualMachine& machine, const std::string& id, Noise& noise, double duration_s, int touches) {
  const auto found = adders().find(id);
  if (found == adders().end()) throw std::invalid_argument("no undeclared effect is called " + id);
  found->second(machine, noise, duration_s, touches);
}

GaugedMaps gauged_maps(const VirtualMachine& machine, const std::vector<double>& tilt_deg,
                       const std::vector<double>& C_deg) {
  const char letter = tilt_letter(machine);
  if (machine.workpiece_axes.size() != 2 || machine.workpiece_axes.front().name != letter)
    throw std::invalid_argument("maps of a machine whose table does not tilt first and turn then");
  const RotaryAxis& tilt_axis = machine.workpiece_axes.front();
  const RotaryAxis& C_axis = machine.workpiece_axes.back();
  GaugedMaps maps{tilt_deg, C_deg, {}, {}, {}};
  for (double tilt : tilt_deg) {
    const std::size_t row = maps.pose.size();
    AxisErrors mean;
    for (double C : C_deg) {
      maps.pose.push_back(machine.pose_error(letter == 'A' ? ac_degrees(tilt, C) : bc_degrees(tilt, C)));
      mean.translation_mm += maps.pose.back().translation_mm / static_cast<double>(C_deg.size());
      mean.rotation_rad += maps.pose.back().rotation_rad / static_cast<double>(C_deg.size());
    }
    maps.tilt.push_back({mean.translation_mm + mean.rotation_rad.cross(tilt_axis.origin_mm), mean.rotation_rad});

    const Eigen::Isometry3d tilted = Eigen::Translation3d(tilt_axis.origin_mm) *
                                     Eigen::AngleAxisd(tilt * kDegree, tilt_axis.direction.normalized()) *
                                     Eigen::Translation3d(-tilt_axis.origin_mm);
    const Vector3d C_origin = tilted * C_axis.origin_mm;
    for (std::size_t j = 0; j < C_deg.size(); ++j) {
      const Vector3d rotation = maps.pose[row + j].rotation_rad - mean.rotation_rad;
      const Vector3d translation = maps.pose[row + j].translation_mm - mean.translation_mm + rotation.cross(C_origin);
      maps.C.push_back({tilted.linear().transpose() * translation, tilted.linear().transpose() * rotation});
    }
  }
  return maps;
}

}  // namespace trunnion::testing
