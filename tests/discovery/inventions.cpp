#include "discovery/inventions.h"

#include <cmath>
#include <numbers>

namespace trunnion::testing {
namespace {

using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

using Displacement = std::function<Vector3d(const MachineState&)>;

/// The workpiece stands displaced against the tool, mm in R.
void displace(VirtualMachine& machine, Displacement mm) {
  machine.workpiece_effects.push_back(
      [mm = std::move(mm)](const MachineState& state) -> Isometry3d { return Isometry3d(Translation3d(mm(state))); });
}

double sign_of(Noise& noise) { return noise.bits() & 1U ? 1 : -1; }

double visits_until(const ProbingPlan& plan, std::size_t touch) {
  int visits = 0;
  for (std::size_t i = 1; i <= touch; ++i)
    visits += plan.touches[i].A_deg != plan.touches[i - 1].A_deg || plan.touches[i].C_deg != plan.touches[i - 1].C_deg;
  return visits;
}

/// A column that wanders from pose to pose, in step with nothing else.
std::function<void(ProbingPlan&)> wandering(const char* column, double low, double high) {
  return [=](ProbingPlan& plan) {
    for (std::size_t i = 0; i < plan.touches.size(); ++i) {
      const double turn = .6180339887498949 * (visits_until(plan, i) + 3 * plan.touches[i].repeat);
      plan.touches[i].covariates[column] = low + (high - low) * (turn - std::floor(turn));
    }
  };
}

void dent_of_a_way(VirtualMachine& m, Noise& n, const UndeclaredSize& size) {
  const double depth = 1.5e-3 * size.scale * sign_of(n), at = n.uniform(-60, 60);
  displace(m, [=](const MachineState& s) {
    return Vector3d(0, 0, depth * std::exp(-std::pow((s.tip_r_mm.x() - at) / 15, 2)));
  });
}
void joint_of_a_scale(VirtualMachine& m, Noise& n, const UndeclaredSize& size) {
  const double step = 1.5e-3 * size.scale * sign_of(n), at = n.uniform(-40, 40);
  displace(m, [=](const MachineState& s) { return Vector3d(s.tip_r_mm.y() > at ? step : 0, 0, 0); });
}
void twisted_column(VirtualMachine& m, Noise& n, const UndeclaredSize& size) {
  const double k = 2e-3 * size.scale * sign_of(n);
  displace(m, [=](const MachineState& s) { return Vector3d(k * s.tip_r_mm.y() * s.tip_r_mm.z() / 1e4, 0, 0); });
}
void table_kicked(VirtualMachine& m, Noise& n, const UndeclaredSize& size) {
  const double x = 1.5e-3 * size.scale * sign_of(n), z = 1e-3 * size.scale * sign_of(n);
  const double at_s = size.duration_s * n.uniform(.3, .7);
  displace(m, [=](const MachineState& s) { return s.time_s > at_s ? Vector3d(x, 0, z) : Vector3d(0, 0, 0); });
}
void sawtooth_in_time(VirtualMachine& m, Noise& n, const UndeclaredSize& size) {
  const double y = 2e-3 * size.scale * sign_of(n), period_s = size.duration_s / n.uniform(2.5, 4.5);
  displace(m, [=](const MachineState& s) {
    return Vector3d(0, y * (s.time_s / period_s - std::floor(s.time_s / period_s)), 0);
  });
}
void growing_scale(VirtualMachine& m, Noise& n, const UndeclaredSize& size) {
  const double k = 15e-6 * size.scale * sign_of(n), whole_s = size.duration_s;
  displace(m, [=](const MachineState& s) { return Vector3d(-k * s.tip_r_mm.x() * s.time_s / whole_s, 0, 0); });
}
void tilt_that_snaps(VirtualMachine& m, Noise& n, const UndeclaredSize& size) {
  const double turn = 15e-6 * size.scale * sign_of(n), at_rad = n.uniform(-70, -40) * kPi / 180;
  m.workpiece_effects.push_back([=](const MachineState& s) -> Isometry3d {
    const double snapped = s.rotary.A_rad < at_rad && s.rotary_sense.of('A') < 0 ? turn : 0;
    return Isometry3d(Eigen::AngleAxisd(snapped, Vector3d::UnitX()));
  });
}
void crosswise_pretravel(VirtualMachine& m, Noise& n, const UndeclaredSize& size) {
  const double mm = 1e-3 * size.scale * sign_of(n);
  m.reading_effects.push_back([=](const TouchState& t) { return mm * std::abs(t.approach_r.x() * t.approach_r.y()); });
}
void one_sided_pretravel(VirtualMachine& m, Noise& n, const UndeclaredSize& size) {
  const double mm = .8e-3 * size.scale * sign_of(n);
  m.reading_effects.push_back([=](const TouchState& t) { return t.approach_r.x() > .3 ? mm : 0; });
}
void coolant(VirtualMachine& m, Noise& n, const UndeclaredSize& size) {
  const double z = 1.5e-3 * size.scale * sign_of(n);
  displace(m, [=](const MachineState& s) { return Vector3d(0, 0, z * std::tanh((s.covariate("flow_lpm") - 12) / 3)); });
}
void relay(VirtualMachine& m, Noise& n, const UndeclaredSize& size) {
  const double x = 1e-3 * size.scale * sign_of(n), y = 1e-3 * size.scale * sign_of(n);
  displace(m,
           [=](const MachineState& s) { return s.covariate("bus_V") > 23.5 ? Vector3d(x, y, 0) : Vector3d(0, 0, 0); });
}
void draught_on_the_probe(VirtualMachine& m, Noise& n, const UndeclaredSize& size) {
  const double mm = 1e-3 * size.scale * sign_of(n);
  m.reading_effects.push_back([=](const TouchState& t) {
    const double f = (t.machine.covariate("draught") - 2) / 2, side = std::hypot(t.approach_r.x(), t.approach_r.y());
    return mm * side * f * f;
  });
}
void tired_operator(VirtualMachine& m, Noise& n, const UndeclaredSize& size) {
  const double mm = 1e-3 * size.scale * sign_of(n), whole = size.touches;
  m.reading_effects.push_back([=](const TouchState& t) { return mm * std::sin(3 * kPi * t.machine.order / whole); });
}

}  // namespace

const std::vector<Invention>& inventions() {
  static const std::vector<Invention> all = {
      {"dent of a way", dent_of_a_way, {}},
      {"joint of a scale", joint_of_a_scale, {}},
      {"twisted column", twisted_column, {}},
      {"table kicked", table_kicked, {}},
      {"sawtooth in time", sawtooth_in_time, {}},
      {"growing scale", growing_scale, {}},
      {"tilt that snaps", tilt_that_snaps, {}},
      {"crosswise pretravel", crosswise_pretravel, {}, false},
      {"one-sided pretravel", one_sided_pretravel, {}, false},
      {"coolant", coolant, wandering("flow_lpm", 5, 20)},
      {"relay", relay, wandering("bus_V", 22, 25)},
      {"draught on the probe", draught_on_the_probe, wandering("draught", 0, 4), false},
      {"tired operator", tired_operator, {}, false},
  };
  return all;
}

}  // namespace trunnion::testing
