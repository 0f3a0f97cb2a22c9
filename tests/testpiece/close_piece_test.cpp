#include <gtest/gtest.h>

#include "testpiece/piece_case.h"

namespace trunnion {
namespace {

using testing::PieceOutcome;

constexpr double kUndeclared_rad = 30e-6;
constexpr double kLeaning_deg = 30;  // more than the half angle: C reverses twice
constexpr double kUpright_deg = 10;  // less: C turns on and on

/// What the backlash did to the roundness is gone: left is what the same piece has of a machine that lacks nothing.
void expect_round(const PieceOutcome& outcome, testing::PieceCase c) {
  c.backlash_rad = 0;
  const double sound_um = testing::close_piece(c).roundness_after_um;
  EXPECT_GT(outcome.roundness_before_um, 1.2 * sound_um);
  EXPECT_NEAR(outcome.roundness_after_um, sound_um, 0.1 * sound_um);
}

TEST(ClosePiece, FindsABacklashOfCFromThePieceAlone) {
  const testing::PieceCase cut{.seed = 7, .tilt_deg = kLeaning_deg, .backlash_rad = kUndeclared_rad};
  const PieceOutcome outcome = testing::close_piece(cut);
  // X turns about where C does: this piece tells the two apart by a few units of log likelihood at most.
  ASSERT_TRUE(outcome.names_the_backlash());
  const AcceptedEffect& first = outcome.closure.effects[0];
  if (first.effect->id() == "backlash:C") {
    EXPECT_NEAR(first.effect->values()[0], -kUndeclared_rad, 0.2 * kUndeclared_rad);
  }
  EXPECT_EQ(outcome.closure.verdict, Verdict::explained);
  EXPECT_LT(outcome.closure.after.rms_um, outcome.closure.before.rms_um);
  expect_round(outcome, cut);
}

TEST(ClosePiece, FindsItTogetherWithAProbingThatCouldNot) {
  const testing::PieceCase cut{
      .seed = 8, .tilt_deg = kLeaning_deg, .backlash_rad = kUndeclared_rad, .with_probing = true};
  const PieceOutcome outcome = testing::close_piece(cut);
  EXPECT_TRUE(outcome.probing_alone->effects.empty()) << "C never turned back while probing";
  ASSERT_TRUE(outcome.names_the_backlash());
  ASSERT_EQ(outcome.closure.effects[0].effect->id(), "backlash:C") << "the probing settles what X does";
  EXPECT_NEAR(outcome.closure.effects[0].effect->values()[0], -kUndeclared_rad, 0.1 * kUndeclared_rad);
  expect_round(outcome, cut);
}

TEST(ClosePiece, SaysThatAConeUnderWhichCNeverReversesCannotTestIt) {
  const PieceOutcome outcome =
      testing::close_piece({.seed = 9, .tilt_deg = kUpright_deg, .backlash_rad = kUndeclared_rad});
  EXPECT_FALSE(outcome.names_the_backlash());
  EXPECT_TRUE(outcome.backlash_is_untestable());
}

TEST(ClosePiece, AddsNothingToTheMapOfASoundMachine) {
  for (std::uint64_t seed = 20; seed < 24; ++seed) {
    const PieceOutcome outcome =
        testing::close_piece({.seed = seed, .tilt_deg = kLeaning_deg, .with_probing = seed % 2 == 0});
    EXPECT_TRUE(outcome.closure.effects.empty()) << outcome.closure.effects[0].effect->id();
  }
}

}  // namespace
}  // namespace trunnion
