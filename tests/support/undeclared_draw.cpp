#include "support/undeclared_draw.h"

#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <stdexcept>

#include "support/undeclared_effects.h"

namespace trunnion::testing {
namespace {

using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

/// The machine, the numbers to draw from, and how large it is to be.
struct Draw {
  VirtualMachine& machine;
  Noise& noise;
  UndeclaredSize size;

  /// Away from zero, so that it can be found: between `typical` and twice that, either sign, times the scale.
  double sized(double typical) const { return (noise.bits() & 1U ? 1 : -1) * positive(typical); }
  double positive(double typical) const { return size.scale * typical * noise.uniform(1, 2); }
};

using Adder = std::function<void(const Draw&)>;

Adder scale(char axis) {
  return [=](const Draw& d) { add_linear_scale(d.machine, axis, d.sized(8e-6)); };
}
Adder squareness(const char* plane, double typical_rad) {
  return [=](const Draw& d) { add_squareness(d.machine, plane, d.sized(typical_rad)); };
}
/// Bent by a square and a cube of the place, per 100 mm.
Adder straightness(const char* symbol) {
  return [=](const Draw& d) {
    const double square = d.sized(2e-3), cube = d.sized(1e-3);
    add_straightness(d.machine, symbol,
                     [=](double x) { return square * std::pow(x / 100, 2) + cube * std::pow(x / 100, 3); });
  };
}
Adder table_angular(const char* symbol) {
  return [=](const Draw& d) {
    const double k = d.sized(10e-6);
    add_table_angular(d.machine, symbol, [=](double y) { return k * y / 100; });
  };
}
Adder periodic(char axis) {
  return [=](const Draw& d) {
    const double amplitude_mm = d.positive(.5e-3), phase_rad = d.noise.uniform(0, 2 * kPi);
    add_linear_periodic(d.machine, axis, amplitude_mm, 10, phase_rad);
  };
}
Adder linear_backlash(char axis) {
  return [=](const Draw& d) { add_linear_backlash(d.machine, axis, d.positive(1.5e-3)); };
}
Adder rotary_backlash(char axis) {
  return [=](const Draw& d) { add_rotary_backlash(d.machine, axis, d.sized(8e-6)); };
}
Adder cyclic(char axis, int order) {
  return [=](const Draw& d) {
    const double a = d.sized(8e-6), b = d.sized(8e-6);
    add_cyclic_error(d.machine, axis, order, a, b);
  };
}
Adder warming(bool turns) {
  return [=](const Draw& d) {
    const double y = d.sized(2), z = d.sized(3), a = d.sized(15);
    const double time_constant_s = d.size.duration_s / d.noise.uniform(4, 8);
    add_thermal_drift(d.machine, turns ? um_urad(0, 0, 0, a, 0, a / 2) : um_urad(0, y, z, 0, 0, 0), time_constant_s);
  };
}
Adder steady_drift(bool turns) {
  return [=](const Draw& d) {
    const double y = d.sized(2), z = d.sized(3), a = d.sized(15), whole_s = d.size.duration_s;
    add_drift(d.machine, [=](double time_s) {
      const double share = time_s / whole_s;
      return turns ? um_urad(0, 0, 0, a * share, 0, a * share / 2) : um_urad(0, y * share, z * share, 0, 0, 0);
    });
  };
}
Adder air_conditioning() {
  return [](const Draw& d) {
    const double x = d.sized(1), z = d.sized(1), period_s = d.noise.uniform(700, 1500);
    add_drift(d.machine, [=](double time_s) {
      const double wave = std::sin(2 * kPi * time_s / period_s);
      return um_urad(x * wave, 0, z * wave, 0, 0, 0);
    });
  };
}
Adder lobing(int lobes) {
  return [=](const Draw& d) {
    const double a = d.sized(.3e-3), b = d.sized(.3e-3);
    add_probe_lobing(d.machine, lobes, a, b);
  };
}
Adder expansion(bool only_height) {
  return [=](const Draw& d) {
    const double kelvin = d.sized(.5), whole_s = d.size.duration_s;
    if (!only_height) {
      add_artifact_expansion(d.machine, 23.8e-6, [=](const MachineState& s) { return kelvin * s.time_s / whole_s; });
      return;
    }
    d.machine.artifact_effects.push_back([=](const TouchState& touch) -> Eigen::Isometry3d {
      const double growth = 23.8e-6 * kelvin * touch.machine.time_s / whole_s;
      return Eigen::Isometry3d(Eigen::Translation3d(0, 0, growth * touch.face.actual_w_mm.z()));
    });
  };
}
Adder slip(const char* artifact) {
  return [=](const Draw& d) {
    const double x = d.sized(1.5), y = d.sized(1.5);
    const int from =
        d.size.touches / 4 + static_cast<int>(d.noise.below(static_cast<std::uint64_t>(d.size.touches) / 2));
    if (std::string(artifact) != "all") {
      add_artifact_slip(d.machine, artifact, um_urad(x, y, 0, 0, 0, 0), from);
      return;
    }
    for (const char* each : {"1", "2", "3"}) add_artifact_slip(d.machine, each, um_urad(x, y, 0, 0, 0, 0), from);
  };
}

const std::map<std::string, Adder>& adders() {
  static const std::map<std::string, Adder> all = {
      {"linear_scale:X", scale('X')},
      {"linear_scale:Y", scale('Y')},
      {"linear_scale:Z", scale('Z')},
      {"squareness:XY", squareness("XY", 8e-6)},
      {"squareness:XZ", squareness("XZ", 8e-6)},
      {"squareness:YZ", squareness("YZ", 15e-6)},
      {"straightness:EYX", straightness("EYX")},
      {"straightness:EZX", straightness("EZX")},
      {"straightness:EXY", straightness("EXY")},
      {"straightness:EZY", straightness("EZY")},
      {"straightness:EXZ", straightness("EXZ")},
      {"straightness:EYZ", straightness("EYZ")},
      {"linear_angular:EAY", table_angular("EAY")},
      {"linear_angular:EBY", table_angular("EBY")},
      {"linear_angular:ECY", table_angular("ECY")},
      {"linear_periodic:X", periodic('X')},
      {"linear_periodic:Y", periodic('Y')},
      {"linear_periodic:Z", periodic('Z')},
      {"linear_backlash:X", linear_backlash('X')},
      {"linear_backlash:Y", linear_backlash('Y')},
      {"backlash:A", rotary_backlash('A')},
      {"backlash:C", rotary_backlash('C')},
      {"cyclic_error:C:6", cyclic('C', 6)},
      {"cyclic_error:C:90", cyclic('C', 90)},
      {"cyclic_error:A:72", cyclic('A', 72)},
      {"thermal_drift", warming(false)},
      {"thermal_drift:rotation", warming(true)},
      {"thermal_drift:linear", steady_drift(false)},
      {"thermal_drift:linear_rotation", steady_drift(true)},
      {"thermal_drift:cycle", air_conditioning()},
      {"temperature", [](const Draw& d) { add_temperature(d.machine, um_urad(0, 0, d.sized(3), 0, 0, 0)); }},
      {"brake_clamp:A", [](const Draw& d) { add_brake_clamp(d.machine, 'A', "A_clamped", d.sized(8e-6)); }},
      {"brake_clamp:C", [](const Draw& d) { add_brake_clamp(d.machine, 'C', "C_clamped", d.sized(8e-6)); }},
      {"payload_sag", [](const Draw& d) { add_payload_sag(d.machine, "payload_kg", 0, d.sized(.4e-6)); }},
      {"probe_lobing:1", lobing(1)},
      {"probe_lobing:2", lobing(2)},
      {"probe_lobing:3", lobing(3)},
      {"probe_lobing:4", lobing(4)},
      {"probe_pretravel", [](const Draw& d) { add_probe_pretravel(d.machine, d.sized(1.5e-3)); }},
      {"probe_settling",
       [](const Draw& d) {
         add_settling(d.machine, {d.sized(.15e-3), d.sized(.15e-3), 0});
       }},
      {"probe_settling:first",
       [](const Draw& d) {
         const Vector3d start_mm(d.sized(1e-3), d.sized(1e-3), 0);
         add_first_touches(d.machine, start_mm, 10);
       }},
      {"artifact_expansion", expansion(false)},
      {"artifact_expansion:time_s:height", expansion(true)},
      {"artifact_slip:1", slip("1")},
      {"artifact_slip:2", slip("2")},
      {"artifact_slip:all", slip("all")},
      {"artifact_creep:1",
       [](const Draw& d) {
         const double x = d.sized(1.5e-3), y = d.sized(1.5e-3);
         add_artifact_creep(d.machine, "1", {x, y, 0}, d.size.duration_s / 4);
       }},
      {"pass_shift:1",
       [](const Draw& d) {
         const double x = d.sized(1e-3), z = d.sized(1e-3);
         add_pass_shift(d.machine, 1, {x, 0, z});
       }},
  };
  return all;
}

}  // namespace

std::vector<std::string> undeclared_ids() {
  std::vector<std::string> ids;
  for (const auto& [id, adder] : adders()) ids.push_back(id);
  return ids;
}

void add_undeclared(VirtualMachine& machine, const std::string& id, Noise& noise, const UndeclaredSize& size) {
  const auto found = adders().find(id);
  if (found == adders().end()) throw std::invalid_argument("no undeclared effect is called " + id);
  found->second({machine, noise, size});
}

void record_covariates(ProbingPlan& plan, const std::string& id) {
  int visit = 0;
  for (std::size_t i = 0; i < plan.touches.size(); ++i) {
    PlannedTouch& touch = plan.touches[i];
    const bool moved = i > 0 && (touch.A_deg != plan.touches[i - 1].A_deg || touch.C_deg != plan.touches[i - 1].C_deg);
    if (moved) ++visit;
    if (id == "temperature") touch.temperature_C = 20 + touch.time_s / 2500 + .3 * std::sin(touch.time_s / 400);
    // Two poses clamped, one open: no rhythm of the grid.
    if (id.starts_with("brake_clamp:")) touch.covariates[id.substr(12) + "_clamped"] = visit % 3 == 0 ? 0 : 1;
    if (id == "payload_sag") touch.covariates["payload_kg"] = touch.repeat % 2 == 1 ? 40 : 0;
  }
}

}  // namespace trunnion::testing
