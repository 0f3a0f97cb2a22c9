#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "testpiece/independent_cut.h"
#include "testpiece/pieces.h"
#include "testpiece/told_errors.h"

namespace trunnion {
namespace {

using testing::VirtualMachine;

constexpr double kAgreement_mm = 0.05e-3;
constexpr double kSeen_mm = 0.2e-3;  // a case that cuts no more than this says nothing

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
  for (const ToldError& told : told_errors()) {
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
    EXPECT_LT(apart, kAgreement_mm) << told.entry["id"];
    EXPECT_GT(most, kSeen_mm) << told.entry["id"];
  }
}

/// No family of the machine is left out above.
TEST(MachiningEffects, HaveACaseForEveryFamilyOfTheMachine) {
  std::set<std::string> cases = {"rotary_error_map", "location_errors", "smooth"};  // machining_test, sensitivity_test
  for (const ToldError& told : told_errors()) cases.insert(told.entry["id"].get<std::string>());
  for (const Family& family : catalogue()) {
    const std::string name(family.name);
    if (name.starts_with("probe_") || name.starts_with("artifact_") || name == "pass_shift") continue;
    EXPECT_TRUE(std::ranges::any_of(cases, [&](const std::string& id) { return id.substr(0, id.find(':')) == name; }))
        << name;
  }
}

}  // namespace
}  // namespace trunnion
