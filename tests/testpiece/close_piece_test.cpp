#include <gtest/gtest.h>

#include "discovery/closure.h"
#include "identification/as_observations.h"
#include "io/piece_observations.h"
#include "support/probing_plan.h"
#include "support/smooth_machine.h"
#include "support/undeclared_effects.h"
#include "testpiece/measured.h"
#include "testpiece/pieces.h"

// A cone is cut by the exact envelope on a machine that has what nobody declared, measured, and asked for its cause.

namespace trunnion {
namespace {

constexpr double kPieceSigma_mm = 0.2e-3, kBacklash_rad = 30e-6;

struct Cut {
  TestPiece piece;
  KinematicChain chain{trunnion_machine()};
  std::vector<ToolPosition> path;
  SurfaceGrid surface;

  explicit Cut(double tilt_deg) : piece(usual_piece(15, tilt_deg)) {
    piece.points = 180;
    piece.tool.length = Length::millimetres(120);
    piece.feed_mm_per_min = 400;
    path = flank_milling_path(piece, chain, {.steps_per_turn = 1800});
    surface = evaluated_surface(piece);
  }
  ObservationSet observed(const testing::VirtualMachine& machine, std::uint64_t seed) const {
    testing::Noise noise(seed);
    const std::vector<double> left = cut_by_brute_force(machine, piece, surface, path, [](testing::MachineState&) {});
    const MeasuredPiece found = measured(surface, left,
                                         {.sigma_mm = kPieceSigma_mm,
                                          .shift_mm = {4e-3, -2e-3, 3e-3},
                                          .turn_rad = {20e-6, 10e-6, -30e-6},
                                          .grown_mm = 2e-3},
                                         noise);
    return observations_of({piece, found, path, chain, {}}).set;
  }
};

testing::VirtualMachine small_machine(std::uint64_t seed) {
  return testing::smooth_machine(seed, {.translation_mm = 1e-3, .rotation_rad = 8e-6, .C_harmonics = 1});
}

bool found(const ClosureResult& closure, const std::string& id) {
  return std::ranges::any_of(closure.effects, [&](const AcceptedEffect& e) { return e.effect->id() == id; });
}

Machine the_machine() {
  Machine machine = trunnion_machine();
  machine.probe.sigma = Length::micrometres(0.175);
  return machine;
}

TEST(ClosePiece, FindsABacklashOfCFromThePieceAlone) {
  testing::VirtualMachine machine = small_machine(7);
  add_rotary_backlash(machine, 'C', kBacklash_rad);
  const Cut cut(30);  // the cone leans more than its half angle: C reverses twice
  const ObservationSet piece = cut.observed(machine, 1);
  const ClosureResult closure = close_loop(piece, piece.rows.size(), the_machine());
  // X turns about where C does: this piece tells the two apart by a few units of log likelihood at most.
  ASSERT_FALSE(closure.effects.empty());
  const AcceptedEffect& first = closure.effects[0];
  EXPECT_TRUE(first.effect->id() == "backlash:C" ||
              std::ranges::find(first.not_separable_from, "backlash:C") != first.not_separable_from.end());
  if (first.effect->id() == "backlash:C") {
    EXPECT_NEAR(first.effect->values()[0], -kBacklash_rad, 0.2 * kBacklash_rad);
  }
  EXPECT_EQ(closure.verdict, Verdict::explained);
  EXPECT_LT(closure.after.rms_um, closure.before.rms_um);
}

TEST(ClosePiece, FindsItTogetherWithAProbingThatCouldNot) {
  testing::VirtualMachine machine = small_machine(8);
  add_rotary_backlash(machine, 'C', kBacklash_rad);
  testing::Noise noise(2);
  testing::ProbingPlan plan = testing::two_top_plan();  // one pass, C always upwards
  plan.faces = testing::as_built(plan.faces, noise, 20e-3, 50e-6);
  const ObservationSet probing = as_observations(probe(machine, plan, {.sigma_mm = 0.175e-3}, noise));
  const ClosureResult alone = close_loop(probing, probing.rows.size(), the_machine());
  const Cut cut(30);
  const ObservationSet both = joined_with_piece(probing, cut.observed(machine, 3));
  const ClosureResult closure = close_loop(both, probing.rows.size(), the_machine());
  ASSERT_TRUE(found(closure, "backlash:C")) << (closure.effects.empty() ? "nothing" : closure.effects[0].effect->id());
  EXPECT_NEAR(closure.effects[0].effect->values()[0], -kBacklash_rad, 0.15 * kBacklash_rad);
  ASSERT_TRUE(found(alone, "backlash:C"));
  EXPECT_LT(closure.effects[0].effect->covariance()(0, 0), alone.effects[0].effect->covariance()(0, 0));
}

TEST(ClosePiece, SaysThatAConeUnderWhichCNeverReversesCannotTestIt) {
  testing::VirtualMachine machine = small_machine(9);
  add_rotary_backlash(machine, 'C', kBacklash_rad);
  const Cut cut(10);  // less than the half angle: C turns on and on
  const ObservationSet piece = cut.observed(machine, 4);
  const ClosureResult closure = close_loop(piece, piece.rows.size(), the_machine());
  EXPECT_FALSE(found(closure, "backlash:C"));
  EXPECT_TRUE(std::ranges::any_of(closure.untestable,
                                  [](const Untestable& u) { return u.id == "backlash:C" || u.id == "backlash"; }));
}

TEST(ClosePiece, AddsNothingToTheMapOfASoundMachine) {
  for (std::uint64_t seed = 20; seed < 23; ++seed) {
    const Cut cut(30);
    const ObservationSet piece = cut.observed(small_machine(seed), seed);
    const ClosureResult closure = close_loop(piece, piece.rows.size(), the_machine());
    EXPECT_TRUE(closure.effects.empty()) << closure.effects[0].effect->id();
  }
}

}  // namespace
}  // namespace trunnion
