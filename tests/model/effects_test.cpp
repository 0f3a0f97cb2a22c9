#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "error.h"
#include "model/catalogue.h"
#include "model/model.h"
#include "support/undeclared_effects.h"
#include "units/angle.h"

namespace trunnion {
namespace {

using Eigen::Vector3d;
using nlohmann::json;
using ::testing::HasSubstr;
using testing::MachineState;
using testing::VirtualMachine;

constexpr double kSecondOrder_mm = 2e-8;  // 10 um or 10 urad at 300 mm: products of errors stay below

/// The same machine twice: as the program sees it, and as it really turns.
struct Rig {
  std::string name;
  Machine machine;
  VirtualMachine real;
  EffectContext context() const { return effect_context(machine); }
};

Rig rig(const std::string& code) {
  Rig r{code, {}, testing::perfect_machine(code)};
  r.machine.structure = parse_structure(code);
  r.machine.axes = default_axes(r.machine.structure);
  return r;
}

Rig placed(Rig r, char axis, const Vector3d& direction, const Vector3d& origin_mm) {
  r.machine.axes.at(axis).direction = direction;
  r.machine.axes.at(axis).origin_mm = origin_mm;
  r.real.axis(axis).direction = direction;
  r.real.axis(axis).origin_mm = origin_mm;
  r.name += std::string(" with ") + axis + " placed elsewhere";
  return r;
}

std::vector<Rig> rigs() {
  return {
      rig("w C' A' Y' b X Z t"),
      placed(placed(rig("w C' A' Y' b X Z t"), 'A', {-1, 0, 0}, {0, 12, -30}), 'C', {0, 0, 1}, {-8, 25, 0}),
      rig("w C' B' Y' b X Z t"),
      placed(rig("w C' X' Y' b Z B t"), 'B', {0, 1, 0}, {0, 0, 150}),
      placed(rig("w X' Y' b Z C B t"), 'B', {0, -1, 0}, {20, 0, 150}),
  };
}

const std::vector<std::string> kColumns = {"load_kg", "A_clamped", "B_clamped", "C_clamped", "spindle_C"};

MachineState state(double tilt_deg, double c_deg, const Vector3d& tip) {
  MachineState s;
  s.rotary = {tilt_deg * kDegree_rad, tilt_deg * kDegree_rad, c_deg * kDegree_rad};
  s.tip_r_mm = tip;
  s.tool_length_mm = 120;
  s.time_s = 500;
  s.temperature_C = 23;
  s.rotary_sense = {-1, -1, -1};
  s.linear_sense = {1, -1, 1};
  s.order = 40;
  s.order_in_pose = 4;
  s.repeat = 1;
  for (const std::string& column : kColumns) s.covariates[column] = column == "load_kg" ? 30 : 1;
  return s;
}

std::vector<MachineState> states() {
  return {state(0, 0, {0, 0, 0}), state(-30, 60, {110, -70, 90}), state(-90, 240, {-60, 130, 40}),
          state(20, 10, {45, 80, -20})};
}

/// Keeps the extra columns alive that its situation points to.
struct Seen {
  std::vector<double> values;
  Situation situation;
};
Seen seen(const MachineState& s) {
  Seen result;
  for (const std::string& column : kColumns) result.values.push_back(s.covariate(column));
  Situation& at = result.situation;
  at.at = {Angle::radians(s.rotary.A_rad), Angle::radians(s.rotary.C_rad)};
  at.point_r_mm = s.tip_r_mm;
  at.tool_length_mm = s.tool_length_mm;
  at.time_s = s.time_s;
  at.temperature_C = s.temperature_C;
  at.tilt_sense = static_cast<int>(s.rotary_sense.A_rad);
  at.turn_sense = static_cast<int>(s.rotary_sense.C_rad);
  at.linear_sense = s.linear_sense;
  at.repeat = s.repeat;
  at.order = s.order;
  at.order_in_pose = s.order_in_pose;
  return result;
}

/// An entry of a model file: values by name, in the units of the effect.
json entry(const std::string& id, const std::map<std::string, std::pair<double, std::string>>& parameters,
           const std::map<std::string, std::pair<double, std::string>>& shape = {}, const json& keys = json::object()) {
  json j = keys;
  j["id"] = id;
  for (const auto& [name, quantity] : parameters)
    j["parameters"][name] = {{"value", quantity.first}, {"unit", quantity.second}};
  for (const auto& [name, quantity] : shape) j["shape"][name] = {{"value", quantity.first}, {"unit", quantity.second}};
  return j;
}

void expect_machine_effect(const Rig& r, const json& told, const std::function<void(VirtualMachine&)>& add) {
  VirtualMachine real = r.real;
  add(real);
  const EffectPtr effect = read_effect(told, r.context());
  EXPECT_EQ(effect->origin(), Origin::machine);
  double largest = 0;
  for (const MachineState& s : states()) {
    Seen at = seen(s);
    at.situation.extra = {&kColumns, at.values.data()};
    const Vector3d model = displacement_mm(effect->at(at.situation), s.tip_r_mm);
    const Vector3d exact = real.deviation_mm(s);
    largest = std::max(largest, exact.norm());
    EXPECT_LT((model - exact).norm(), kSecondOrder_mm)
        << told["id"] << " on " << r.name << "\nmodel " << model.transpose() << "\nexact " << exact.transpose();
  }
  EXPECT_GT(largest, 50 * kSecondOrder_mm) << told["id"] << " moves nothing on " << r.name;
}

TEST(Effects, OfLinearAxesMoveTheTipAsTheExactMachineDoes) {
  for (const Rig& r : rigs()) {
    expect_machine_effect(r, entry("linear_scale:X", {{"EXX", {20, "um/m"}}}),
                          [](VirtualMachine& m) { add_linear_scale(m, 'X', 20e-6); });
    expect_machine_effect(r, entry("squareness:XY", {{"EC0Y", {15, "urad"}}}),
                          [](VirtualMachine& m) { add_squareness(m, "XY", 15e-6); });
    expect_machine_effect(r, entry("squareness:XZ", {{"EB0Z", {15, "urad"}}}),
                          [](VirtualMachine& m) { add_squareness(m, "XZ", 15e-6); });
    expect_machine_effect(r, entry("squareness:YZ", {{"EA0Z", {15, "urad"}}}),
                          [](VirtualMachine& m) { add_squareness(m, "YZ", 15e-6); });
    for (const std::string symbol : {"EYX", "EZX", "EXY", "EZY", "EXZ", "EYZ"})
      expect_machine_effect(
          r, entry("straightness:" + symbol, {{"quadratic", {200, "um/m^2"}}, {"cubic", {900, "um/m^3"}}}),
          [symbol](VirtualMachine& m) {
            add_straightness(m, symbol, [](double x) { return 200e-9 * x * x + 900e-12 * x * x * x; });
          });
    const double phase = 0.7;
    expect_machine_effect(
        r,
        entry("linear_periodic:Z", {{"cos", {0.5 * std::cos(phase), "um"}}, {"sin", {-0.5 * std::sin(phase), "um"}}},
              {{"period", {12.5, "mm"}}}),
        [phase](VirtualMachine& m) { add_linear_periodic(m, 'Z', 0.5e-3, 12.5, phase); });
    expect_machine_effect(r, entry("linear_backlash:Y", {{"reversal", {3, "um"}}}),
                          [](VirtualMachine& m) { add_linear_backlash(m, 'Y', 3e-3); });
  }
}

TEST(Effects, OfSlidesTurnTheTableOrTheToolByTheStructure) {
  const Rig r = rig("w C' A' Y' b X Z t");
  for (const std::string about : {"A", "B", "C"}) {
    const std::string of_table = "E" + about + "Y", of_tool = "E" + about + "Z";
    expect_machine_effect(
        r, entry("linear_angular:" + of_table, {{of_table, {40, "urad/m"}}}),
        [of_table](VirtualMachine& m) { add_table_angular(m, of_table, [](double y) { return 40e-9 * y; }); });
    if (about != "C")  // a tool that rolls about its own axis moves no tip
      expect_machine_effect(
          r, entry("linear_angular:" + of_tool, {{of_tool, {40, "urad/m"}}}),
          [of_tool](VirtualMachine& m) { add_tool_angular(m, of_tool, [](double z) { return 40e-9 * z; }); });
  }
  // X carries Z: its pitch EBX swings the tip by the height of the tip, d = -theta e_y x (0, 0, z).
  const EffectPtr pitch = read_effect(entry("linear_angular:EBX", {{"EBX", {40, "urad/m"}}}), r.context());
  Situation at;
  at.point_r_mm = {100, 50, 80};
  const Vector3d d = displacement_mm(pitch->at(at), at.point_r_mm);
  EXPECT_LT((d - Vector3d(-40e-9 * 100 * 80, 0, 0)).norm(), kSecondOrder_mm);
  EXPECT_TRUE(read_effect(entry("linear_angular:EAY", {{"EAY", {1, "urad/m"}}}), r.context())->moves_table());
  EXPECT_FALSE(pitch->moves_table());
}

TEST(Effects, OfRotaryAxesAreExactOnEitherSideAndWhereverTheAxesLie) {
  for (const Rig& r : rigs()) {
    const char tilt = r.machine.tilt_letter();
    for (const char axis : {tilt, 'C'}) {
      const std::string letter(1, axis);
      expect_machine_effect(r, entry("backlash:" + letter, {{"reversal", {-8, "urad"}}}),
                            [axis](VirtualMachine& m) { add_rotary_backlash(m, axis, 8e-6); });
      expect_machine_effect(
          r, entry("brake_clamp:" + letter, {{"step", {8, "urad"}}}, {}, {{"column", letter + "_clamped"}}),
          [&](VirtualMachine& m) { add_brake_clamp(m, axis, letter + "_clamped", 8e-6); });
      for (const int order : {1, 6, 91})
        expect_machine_effect(r,
                              entry("cyclic_error:" + letter + ":" + std::to_string(order),
                                    {{"cos", {6, "urad"}}, {"sin", {-4, "urad"}}}),
                              [=](VirtualMachine& m) { add_cyclic_error(m, axis, order, 6e-6, -4e-6); });
    }
  }
}

TEST(Effects, PayloadSagIsThatOfALoadedTable) {
  const Rig r = rig("w C' A' Y' b X Z t");
  const json told = entry("payload_sag", {{"sin", {0.3, "urad/kg"}}, {"cos", {0, "urad/kg"}}, {"seat", {0, "urad/kg"}}},
                          {}, {{"column", "load_kg"}});
  expect_machine_effect(r, told, [](VirtualMachine& m) { add_payload_sag(m, "load_kg", 0, 0.3e-6); });

  // With a part that stands at A = 0 already: set-up under load takes it out, a reading of a loaded body sees it.
  const json offset =
      entry("payload_sag", {{"sin", {0, "urad/kg"}}, {"cos", {0.3, "urad/kg"}}, {"seat", {0.3, "urad/kg"}}}, {},
            {{"column", "load_kg"}});
  const EffectPtr effect = read_effect(offset, r.context());
  VirtualMachine real = r.real;
  add_payload_sag(real, "load_kg", 0, 0.3e-6, std::numbers::pi / 2);
  for (const MachineState& s : states()) {
    Seen at = seen(s);
    at.situation.extra = {&kColumns, at.values.data()};
    at.situation.reading = ReadingKind::contact;
    EXPECT_LT((displacement_mm(effect->at(at.situation), s.tip_r_mm) - real.deviation_mm(s)).norm(), kSecondOrder_mm);
    at.situation.reading = ReadingKind::none;
    MachineState set_up = s;
    set_up.rotary = {};
    const Eigen::Isometry3d delta =
        real.r_from_w(s) * real.r_from_w(set_up).inverse() * real.r_from_w_nominal(s.rotary).inverse();
    EXPECT_LT((displacement_mm(effect->at(at.situation), s.tip_r_mm) - (delta * s.tip_r_mm - s.tip_r_mm)).norm(),
              kSecondOrder_mm);
  }
}

TEST(Effects, OfTimeAndTemperatureMoveTheTable) {
  for (const Rig& r : rigs()) {
    const testing::AxisErrors end = testing::um_urad(1, -2, 4, 5, -6, 7);
    const testing::AxisErrors shift{end.translation_mm, Vector3d::Zero()}, turn{Vector3d::Zero(), end.rotation_rad};
    const auto xyz = [](const std::string& unit) {
      return std::map<std::string, std::pair<double, std::string>>{
          {"X", {1, unit}}, {"Y", {-2, unit}}, {"Z", {4, unit}}};
    };
    const auto abc = [](const std::string& unit) {
      return std::map<std::string, std::pair<double, std::string>>{
          {"A", {5, unit}}, {"B", {-6, unit}}, {"C", {7, unit}}};
    };
    expect_machine_effect(r, entry("thermal_drift", xyz("um"), {{"time_constant", {720, "s"}}}),
                          [&](VirtualMachine& m) { add_thermal_drift(m, shift, 720); });
    expect_machine_effect(r, entry("thermal_drift:rotation", abc("urad"), {{"time_constant", {720, "s"}}}),
                          [&](VirtualMachine& m) { add_thermal_drift(m, turn, 720); });
    const auto in_hours = [](const testing::AxisErrors& e) {
      return [e](double t) { return testing::AxisErrors{e.translation_mm * t / 3600, e.rotation_rad * t / 3600}; };
    };
    expect_machine_effect(r, entry("thermal_drift:linear", xyz("um/h")),
                          [&](VirtualMachine& m) { add_drift(m, in_hours(shift)); });
    expect_machine_effect(r, entry("thermal_drift:linear_rotation", abc("urad/h")),
                          [&](VirtualMachine& m) { add_drift(m, in_hours(turn)); });
    expect_machine_effect(r,
                          entry("thermal_drift:cycle",
                                {{"cosX", {1, "um"}},
                                 {"cosY", {0, "um"}},
                                 {"cosZ", {0, "um"}},
                                 {"sinX", {0, "um"}},
                                 {"sinY", {2, "um"}},
                                 {"sinZ", {0, "um"}}},
                                {{"period", {1200, "s"}}}),
                          [](VirtualMachine& m) {
                            add_drift(m, [](double t) {
                              const double w = 2 * std::numbers::pi * t / 1200;
                              return testing::um_urad(std::cos(w) - 1, 2 * std::sin(w), 0, 0, 0, 0);
                            });
                          });
    expect_machine_effect(r, entry("temperature", xyz("um/K")), [&](VirtualMachine& m) { add_temperature(m, shift); });
    expect_machine_effect(r, entry("temperature:rotation", abc("urad/K")),
                          [&](VirtualMachine& m) { add_temperature(m, turn); });
    expect_machine_effect(
        r, entry("temperature:expansion", {{"EXX", {11, "um/m/K"}}, {"EYY", {9, "um/m/K"}}, {"EZZ", {-7, "um/m/K"}}}),
        [](VirtualMachine& m) {  // at the 23 C of the states
          add_linear_scale(m, 'X', 33e-6);
          add_linear_scale(m, 'Y', 27e-6);
          add_linear_scale(m, 'Z', -21e-6);
        });
  }
}

void expect_measurement_effect(const Rig& r, const json& told, const std::function<void(VirtualMachine&)>& add) {
  VirtualMachine real = r.real;
  add(real);
  const EffectPtr effect = read_effect(told, r.context());
  EXPECT_EQ(effect->origin(), Origin::measurement);
  double largest = 0;
  for (const Vector3d& outward : {Vector3d(1, 0, 0), Vector3d(0, -1, 0), Vector3d(0.6, 0, 0.8), Vector3d(0, 0, 1)})
    for (const MachineState& s : states()) {
      const testing::Face face{"2S1", "2", {90, -70, 60}, outward, {90, -70, 60}, outward};
      Seen at = seen(s);
      at.situation.extra = {&kColumns, at.values.data()};
      at.situation.reading = ReadingKind::contact;
      at.situation.artifact = "2";
      at.situation.approach_r = r.real.approach_r(face, s.rotary);
      at.situation.point_r_mm = r.real.nominal_contact_r_mm(face, s.rotary);
      const double exact = at.situation.approach_r.dot(real.touch(face, s) - r.real.touch(face, s));
      const double model =
          at.situation.approach_r.dot(displacement_mm(effect->at(at.situation), at.situation.point_r_mm));
      largest = std::max(largest, std::abs(exact));
      EXPECT_NEAR(model, exact, kSecondOrder_mm) << told["id"] << " on " << r.name;
      at.situation.reading = ReadingKind::none;
      at.situation.approach_r.setZero();
      EXPECT_EQ(effect->basis(at.situation).norm(), 0) << told["id"] << " acts while cutting";
    }
  EXPECT_GT(largest, 50 * kSecondOrder_mm) << told["id"];
}

TEST(Effects, OfTheMeasurementChangeReadingsAsTheExactProbeDoes) {
  const std::map<std::string, std::pair<double, std::string>> step = {
      {"X", {2, "um"}}, {"Y", {-1.5, "um"}}, {"Z", {1, "um"}}};
  const Vector3d g(2e-3, -1.5e-3, 1e-3);
  for (const Rig& r : rigs()) {
    for (const int lobes : {1, 2, 3, 4})
      expect_measurement_effect(
          r, entry("probe_lobing:" + std::to_string(lobes), {{"cos", {0.4, "um"}}, {"sin", {-0.3, "um"}}}),
          [lobes](VirtualMachine& m) { add_probe_lobing(m, lobes, 0.4e-3, -0.3e-3); });
    expect_measurement_effect(r, entry("probe_pretravel", {{"axial", {0.6, "um"}}}),
                              [](VirtualMachine& m) { add_probe_pretravel(m, 0.6e-3); });
    expect_measurement_effect(r, entry("probe_settling", step), [g](VirtualMachine& m) { add_settling(m, g); });
    expect_measurement_effect(r, entry("probe_settling:first", step, {{"decay_touches", {10, "1"}}}),
                              [g](VirtualMachine& m) { add_first_touches(m, g, 10); });
    expect_measurement_effect(r, entry("artifact_expansion", {{"expansion", {23.6, "um/m/K"}}}), [](VirtualMachine& m) {
      add_artifact_expansion(m, 23.6e-6, [](const MachineState& s) { return s.temperature_C - 20; });
    });
    expect_measurement_effect(r, entry("artifact_expansion:time_s", {{"expansion", {90, "um/m/h"}}}),
                              [](VirtualMachine& m) {
                                add_artifact_expansion(m, 90e-6, [](const MachineState& s) { return s.time_s / 3600; });
                              });
    expect_measurement_effect(
        r, entry("artifact_expansion:warm_up", {{"expansion", {20, "um/m"}}}, {{"time_constant", {600, "s"}}}),
        [](VirtualMachine& m) {
          add_artifact_expansion(m, 20e-6, [](const MachineState& s) { return 1 - std::exp(-s.time_s / 600); });
        });
    expect_measurement_effect(r, entry("artifact_slip:2", step, {{"moment", {40, "1"}}}), [g](VirtualMachine& m) {
      add_artifact_slip(m, "2", {g, Vector3d::Zero()}, 40);
    });
    expect_measurement_effect(r, entry("artifact_creep:2", step, {{"time_constant", {900, "s"}}}),
                              [g](VirtualMachine& m) { add_artifact_creep(m, "2", g, 900); });
    expect_measurement_effect(r, entry("pass_shift:1", step), [g](VirtualMachine& m) { add_pass_shift(m, 1, g); });
  }
  const Rig seed = rig("w C' A' Y' b X Z t");
  expect_measurement_effect(seed, entry("artifact_flex:2", {{"bending", {3, "um"}}}), [](VirtualMachine& m) {
    m.artifact_effects.emplace_back([](const testing::TouchState& touch) -> Eigen::Isometry3d {
      // Gravity in W: Rz(-C) Rx(-A) (0, 0, -1), its part across the column.
      const double a = touch.machine.rotary.A_rad, c = touch.machine.rotary.C_rad;
      const Vector3d moved = -3e-3 * std::sin(a) * Vector3d(std::sin(c), std::cos(c), 0);
      return Eigen::Isometry3d(Eigen::Translation3d(moved));
    });
  });
}

/// Readings that carry every column, over two passes of some poses and three bodies.
struct Data {
  std::vector<std::string> names = kColumns;
  std::vector<std::vector<double>> extra;
  std::vector<std::string> labels = {"1", "2", "3"};
  std::vector<Situation> readings;
};
Data data() {
  Data d;
  const int n = 2 * 4 * 6 * 6;
  for (int i = 0; i < n; ++i)
    d.extra.push_back({i % 5 * 10.0, double(i % 2), double(i % 2), double(i / 3 % 2), 20 + 0.01 * i});
  for (int i = 0; i < n; ++i) {
    Situation s;
    const int pose = i / 6;
    s.at = {Angle::degrees(-30.0 * (pose / 6 % 4)), Angle::degrees(60.0 * (pose % 6))};
    s.point_r_mm = {90 * std::cos(1.7 * i), 110 * std::sin(1.1 * i), 80 + 40 * std::cos(0.3 * i)};
    s.approach_r = Vector3d(std::cos(i), std::sin(i), 0.3).normalized();
    s.linear_sense = s.approach_r.cwiseSign();
    s.reading = ReadingKind::contact;
    s.time_s = 7.0 * i;
    s.temperature_C = 20 + 0.002 * i;
    s.order = i;
    s.order_in_pose = i % 6;
    s.repeat = i / (n / 2);
    s.artifact = d.labels[static_cast<std::size_t>(i / 2 % 3)];
    s.extra = {&d.names, d.extra[static_cast<std::size_t>(i)].data()};
    d.readings.push_back(s);
  }
  for (Situation& s : d.readings) s.extra.names = nullptr;
  return d;
}

std::vector<EffectPtr> all_candidates(Data& d, const EffectContext& context) {
  for (Situation& s : d.readings) s.extra.names = &d.names;
  CandidateScope scope{context, d.readings, {"time_s", "temperature_C", "A_dir", "C_dir", "repeat"}, d.labels};
  scope.columns.insert(scope.columns.end(), d.names.begin(), d.names.end());
  std::vector<EffectPtr> found;
  for (const Family& family : catalogue())
    for (EffectPtr& candidate : family.candidates(scope)) {
      EXPECT_TRUE(candidate->id() == family.name || candidate->id().starts_with(std::string(family.name) + ":"));
      found.push_back(std::move(candidate));
    }
  return found;
}

TEST(Effects, EveryCandidateComesBackFromItsFileWithValuesShapeAndCovariance) {
  for (const Rig& r : rigs()) {
    Data d = data();
    for (const EffectPtr& candidate : all_candidates(d, r.context())) {
      const auto n = static_cast<Eigen::Index>(candidate->parameters().size());
      Eigen::VectorXd values(n);
      for (Eigen::Index k = 0; k < n; ++k) values[k] = 1e-3 * (1.0 + 0.37 * static_cast<double>(k));
      const Eigen::MatrixXd a = Eigen::MatrixXd::Identity(n, n) + 0.2 * Eigen::MatrixXd::Ones(n, n);
      const EffectPtr written = candidate->with_parameters(values, 1e-8 * a);
      const EffectPtr read = read_effect(json::parse(written->to_json().dump()), r.context());
      EXPECT_EQ(read->id(), written->id());
      EXPECT_LT((read->values() - values).norm(), 1e-14 * values.norm()) << read->id();
      EXPECT_LT((read->covariance() - written->covariance()).norm(), 1e-13 * written->covariance().norm());
      EXPECT_EQ(read->depends_on(), written->depends_on());
      EXPECT_EQ(read->shape().size(), read->shape_ranges().size()) << read->id();
      for (const Situation& s : {d.readings[17], d.readings[200]})
        EXPECT_LT((read->basis(s) - written->basis(s)).norm(), 1e-11 * (1 + written->basis(s).norm())) << read->id();
    }
  }
}

TEST(Effects, NothingActsAtTheZeroOfEveryEffect) {
  for (const Rig& r : rigs()) {
    Data d = data();
    for (const EffectPtr& candidate : all_candidates(d, r.context())) {
      if (candidate->id().starts_with("linear_periodic"))
        continue;  // a function of place, with no place of its own zero
      EXPECT_EQ(candidate->basis(Situation()).norm(), 0) << candidate->id();
      Situation elsewhere;  // zero but for the pose: only what is of the rotary axes may act
      elsewhere.at = {Angle::degrees(-30), Angle::degrees(60)};
      if (candidate->id().starts_with("cyclic_error")) continue;
      EXPECT_EQ(candidate->basis(elsewhere).norm(), 0) << candidate->id();
    }
  }
}

TEST(Effects, SetAsideCleanTheFitAndAreNeverCompensated) {
  const Rig r = rig("w C' A' Y' b X Z t");
  const json entry = {{"id", "backlash:C"},
                      {"parameters", {{"reversal", {{"value", 20}, {"std", 1}, {"unit", "urad"}}}}}};
  const EffectPtr effect = read_effect(entry, r.context()), aside = effect->suspended();
  Situation s;
  s.at = {Angle::degrees(-20), Angle::degrees(50)};
  s.point_r_mm = {80, 20, 30};
  s.turn_sense = -1;
  EXPECT_TRUE(effect->is_compensated());
  EXPECT_FALSE(aside->is_compensated());
  EXPECT_EQ(aside->origin(), Origin::machine);
  EXPECT_EQ(aside->at(s).vector(), effect->at(s).vector());  // in the fit it acts as ever
  EXPECT_GT(deviation_mm(Model{.effects = {effect}}, s).norm(), 1e-3);
  EXPECT_EQ(deviation_mm(Model{.effects = {aside}}, s).norm(), 0);
  EXPECT_EQ(deviation_covariance_mm2(Model{.effects = {aside}}, s).norm(), 0);
  EXPECT_TRUE(needed_covariates(Model{.effects = {aside}}).empty());
  // And so in a file.
  EXPECT_FALSE(effect->to_json().contains("suspended"));
  EXPECT_FALSE(read_effect(aside->to_json(), r.context())->is_compensated());
  json wrong = aside->to_json();
  wrong["suspended"] = "yes";
  EXPECT_THAT([&] { read_effect(wrong, r.context()); },
              ::testing::ThrowsMessage<ModelError>(HasSubstr("suspended: \"yes\" found, true or false is wanted")));
}

TEST(Effects, CandidatesStayAModestNumberAndSkipWhatTheDataDoNotCarry) {
  const Rig r = rig("w C' A' Y' b X Z t");
  Data d = data();
  Eigen::Index columns = 0;
  std::set<std::string> orders;
  for (const EffectPtr& candidate : all_candidates(d, r.context())) {
    columns += static_cast<Eigen::Index>(candidate->parameters().size());
    if (candidate->id().starts_with("cyclic_error:C")) orders.insert(candidate->id());
  }
  EXPECT_LT(columns, 1200);
  EXPECT_THAT(orders, ::testing::ElementsAre("cyclic_error:C:1", "cyclic_error:C:2", "cyclic_error:C:3"))
      << "every other order is an alias at six equal angles";

  const CandidateScope bare{r.context(), d.readings, {}, d.labels};
  for (const char* name : {"thermal_drift", "temperature", "payload_sag", "brake_clamp", "artifact_creep"})
    EXPECT_TRUE(family_of(name).candidates(bare).empty()) << name;
}

TEST(Effects, UnknownNamesAreAnsweredWithTheNearest) {
  const EffectContext context = rig("w C' A' Y' b X Z t").context();
  const auto message = [&](const json& told) -> std::string {
    try {
      read_effect(told, context);
    } catch (const ModelError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message(entry("squarness:XY", {})),
            "effect \"squarness:XY\": no such family; the nearest is \"squareness\"");
  EXPECT_THAT(message(entry("squareness:YX", {})), HasSubstr("XY, XZ or YZ is wanted"));
  EXPECT_THAT(message(entry("cyclic_error:B:3", {})), HasSubstr("cyclic_error:B:3: a rotary axis of the machine"));
  EXPECT_THAT(message(entry("brake_clamp:C", {})), HasSubstr("column is missing"));
  EXPECT_THAT(message(entry("linear_periodic:X", {{"cos", {1, "um"}}, {"sin", {1, "um"}}})),
              HasSubstr("\"shape\" is missing"));
  EXPECT_EQ(message(entry("linear_periodic:X", {{"cos", {1, "um"}}, {"sin", {1, "um"}}}, {{"period", {-3, "mm"}}})),
            "effect linear_periodic:X: shape.period: -3.0 found, a number of 0.001 to 10000.0 mm is wanted");
}

}  // namespace
}  // namespace trunnion
