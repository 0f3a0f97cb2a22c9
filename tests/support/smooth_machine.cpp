#include "support/smooth_machine.h"

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace trunnion::testing {
namespace {

using Eigen::Vector3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kPerDegree = std::numbers::pi / 180;

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
                                     Eigen::AngleAxisd(tilt * kPerDegree, tilt_axis.direction.normalized()) *
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
