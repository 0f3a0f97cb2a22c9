#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "support/undeclared_effects.h"
#include "testpiece/independent_cut.h"
#include "testpiece/pieces.h"

namespace trunnion {
namespace {

using nlohmann::json;
using testing::VirtualMachine;

constexpr double kIndependent_mm = 0.05e-3;
constexpr double kSeen_mm = 0.2e-3;  // a case that cuts no more than this says nothing

/// An error of the machine told twice: as an entry of a model, and as the exact machine has it.
struct Told {
  json entry;
  std::function<void(VirtualMachine&)> add;
};

json entry(const std::string& id, const std::map<std::string, std::pair<double, std::string>>& parameters,
           const json& keys = json::object()) {
  json j = keys;
  j["id"] = id;
  for (const auto& [name, quantity] : parameters)
    j["parameters"][name] = {{"value", quantity.first}, {"unit", quantity.second}};
  return j;
}

json with_shape(json j, const std::string& name, double value, const std::string& unit) {
  j["shape"][name] = {{"value", value}, {"unit", unit}};
  return j;
}

/// One of every family of the machine.
std::vector<Told> machine_errors() {
  const testing::AxisErrors per_kelvin = testing::um_urad(2, -3, 4, 0, 0, 0);
  return {
      {entry("linear_scale:X", {{"EXX", {60, "um/m"}}}), [](VirtualMachine& m) { add_linear_scale(m, 'X', 60e-6); }},
      {entry("squareness:YZ", {{"EA0Z", {80, "urad"}}}), [](VirtualMachine& m) { add_squareness(m, "YZ", 80e-6); }},
      {entry("straightness:EYX", {{"quadratic", {900, "um/m^2"}}, {"cubic", {0, "um/m^3"}}}),
       [](VirtualMachine& m) { add_straightness(m, "EYX", [](double x) { return 900e-9 * x * x; }); }},
      {entry("linear_angular:EAY", {{"EAY", {400, "urad/m"}}}),
       [](VirtualMachine& m) { add_table_angular(m, "EAY", [](double y) { return 400e-9 * y; }); }},
      {entry("linear_angular:EAZ", {{"EAZ", {400, "urad/m"}}}),
       [](VirtualMachine& m) { add_tool_angular(m, "EAZ", [](double z) { return 400e-9 * z; }); }},
      {with_shape(entry("linear_periodic:Y", {{"cos", {3, "um"}}, {"sin", {0, "um"}}}), "period", 12.5, "mm"),
       [](VirtualMachine& m) { add_linear_periodic(m, 'Y', 3e-3, 12.5, 0); }},
      {entry("linear_backlash:Y", {{"reversal", {6, "um"}}}),
       [](VirtualMachine& m) { add_linear_backlash(m, 'Y', 6e-3); }},
      {entry("backlash:A", {{"reversal", {-80, "urad"}}}),
       [](VirtualMachine& m) { add_rotary_backlash(m, 'A', 80e-6); }},
      {entry("backlash:C", {{"reversal", {-80, "urad"}}}),
       [](VirtualMachine& m) { add_rotary_backlash(m, 'C', 80e-6); }},
      {entry("cyclic_error:C:12", {{"cos", {60, "urad"}}, {"sin", {-40, "urad"}}}),
       [](VirtualMachine& m) { add_cyclic_error(m, 'C', 12, 60e-6, -40e-6); }},
      {entry("brake_clamp:A", {{"step", {80, "urad"}}}, {{"column", "A_clamped"}}),
       [](VirtualMachine& m) { add_brake_clamp(m, 'A', "A_clamped", 80e-6); }},
      {entry("payload_sag", {{"sin", {4, "urad/kg"}}, {"cos", {0, "urad/kg"}}, {"seat", {0, "urad/kg"}}},
             {{"column", "load_kg"}}),
       [](VirtualMachine& m) { add_payload_sag(m, "load_kg", 0, 4e-6); }},
      {with_shape(entry("thermal_drift", {{"X", {8, "um"}}, {"Y", {-6, "um"}}, {"Z", {9, "um"}}}), "time_constant", 20,
                  "s"),
       [](VirtualMachine& m) { add_thermal_drift(m, testing::um_urad(8, -6, 9, 0, 0, 0), 20); }},
      {entry("temperature", {{"X", {2, "um/K"}}, {"Y", {-3, "um/K"}}, {"Z", {4, "um/K"}}}),
       [=](VirtualMachine& m) { add_temperature(m, per_kelvin); }},
  };
}

/// Every effect of the machine, with its senses of motion, its time and its covariates, is cut into the piece as an
/// exact machine cuts it.
TEST(MachiningEffects, AreCutAsTheExactMachineCutsThem) {
  TestPiece piece = usual_piece(15, 30);
  piece.points = 24;
  piece.heights = {Length::millimetres(2), Length::millimetres(18)};
  piece.tool.length = Length::millimetres(120);
  piece.feed_mm_per_min = 400;
  const KinematicChain chain(trunnion_machine());
  const std::vector<ToolPosition> path = flank_milling_path(piece, chain, {.steps_per_turn = 1800});
  const SurfaceGrid surface = evaluated_surface(piece);
  const std::vector<std::string> names = {"load_kg", "A_clamped"};
  const std::vector<double> values = {20, 1};
  const Situation known{.temperature_C = 22, .extra = {&names, values.data()}};
  for (const Told& told : machine_errors()) {
    const Model model{.effects = {read_effect(told.entry, effect_context(trunnion_machine()))}};
    const std::vector<double> predicted =
        envelope_deviation_mm(piece, surface, actual_tools(path, chain, model, piece.tool.length, known));
    VirtualMachine machine = testing::perfect_machine("w C' A' Y' b X Z t");
    told.add(machine);
    const std::vector<double> cut =
        cut_by_brute_force(machine, piece, surface, path, [&](testing::MachineState& state) {
          state.temperature_C = 22;
          for (std::size_t k = 0; k < names.size(); ++k) state.covariates[names[k]] = values[k];
        });
    double most = 0, apart = 0;
    for (std::size_t i = 0; i < cut.size(); ++i) {
      most = std::max(most, std::abs(cut[i]));
      apart = std::max(apart, std::abs(cut[i] - predicted[i]));
    }
    EXPECT_LT(apart, kIndependent_mm) << told.entry["id"];
    EXPECT_GT(most, kSeen_mm) << told.entry["id"];
  }
}

/// No family of the machine is left out above.
TEST(MachiningEffects, HaveACaseForEveryFamilyOfTheMachine) {
  std::set<std::string> cases = {"rotary_error_map", "location_errors", "smooth"};  // machining_test, sensitivity_test
  for (const Told& told : machine_errors()) cases.insert(told.entry["id"].get<std::string>());
  for (const Family& family : catalogue()) {
    const std::string name(family.name);
    if (name.starts_with("probe_") || name.starts_with("artifact_") || name == "pass_shift") continue;
    EXPECT_TRUE(std::ranges::any_of(cases, [&](const std::string& id) { return id.substr(0, id.find(':')) == name; }))
        << name;
  }
}

}  // namespace
}  // namespace trunnion
