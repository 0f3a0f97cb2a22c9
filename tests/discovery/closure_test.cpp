#include <gmock/gmock.h>

#include <cmath>

#include "discovery/closure_case.h"

namespace trunnion {
namespace {

using testing::close_case;
using testing::map_error_um;

TEST(Closure, AddsNothingWhereNothingIsMissing) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    const testing::ClosureOutcome outcome = close_case({.seed = seed});
    EXPECT_TRUE(outcome.closure.effects.empty()) << outcome.closure.effects.front().effect->id();
    EXPECT_EQ(outcome.closure.verdict, Verdict::nothing_missing);
  }
}

TEST(Closure, AddsNothingWithoutAVerificationEither) {
  const testing::ClosureOutcome outcome = close_case({.seed = 31, .measured = testing::Measured::calibration});
  EXPECT_TRUE(outcome.closure.effects.empty());
  EXPECT_EQ(outcome.closure.verdict, Verdict::nothing_missing);
}

TEST(Closure, NamesAnUndeclaredSquarenessAndMendsTheMap) {
  const testing::ClosureOutcome outcome = close_case({.seed = 1, .effects = {"squareness:XY"}});
  ASSERT_TRUE(outcome.found("squareness:XY"));
  EXPECT_EQ(outcome.closure.verdict, Verdict::explained);
  EXPECT_LT(outcome.closure.after.reduced_chi2, 1.2);
  EXPECT_LT(outcome.closure.after.holdout_rms_um, 0.8 * outcome.closure.before.holdout_rms_um);
  // The extended model predicts the machine, the bare map does not.
  Model bare = outcome.closure.model;
  bare.effects.resize(1);
  EXPECT_LT(map_error_um(outcome.closure.model, outcome), 0.5 * map_error_um(bare, outcome));
}

TEST(Closure, NamesAnUndeclaredBacklash) {
  const testing::ClosureOutcome outcome = close_case({.seed = 0, .effects = {"backlash:C"}});
  EXPECT_TRUE(outcome.found("backlash:C"));
  EXPECT_EQ(outcome.closure.verdict, Verdict::explained);
}

TEST(Closure, NamesADriftAsOfTheMachineAndASlipAsOfTheMeasurement) {
  const testing::ClosureOutcome drift =
      close_case({.seed = 2, .effects = {"thermal_drift"}, .measured = testing::Measured::three_passes});
  ASSERT_EQ(drift.closure.effects.size(), 1U);
  EXPECT_EQ(drift.closure.effects[0].effect->origin(), Origin::machine);
  const testing::ClosureOutcome slip = close_case({.seed = 0, .effects = {"artifact_slip:2"}});
  ASSERT_TRUE(slip.found("artifact_slip:2"));
  EXPECT_EQ(slip.closure.effects[0].effect->origin(), Origin::measurement);
  // A slip of the artifact is never compensated: the deviation of the model is the map's.
  Model bare = slip.closure.model;
  bare.effects.resize(1);
  Situation s;
  s.at = {Angle::degrees(-40), Angle::degrees(77)};
  s.point_r_mm = {50, 60, 70};
  EXPECT_EQ(deviation_mm(slip.closure.model, s), deviation_mm(bare, s));
}

TEST(Closure, LetsChipsNeitherBecomeAnEffectNorHideOne) {
  const testing::TouchNoise chips{.sigma_mm = 0.175e-3, .chip_rate = 0.02};
  const testing::ClosureOutcome nothing = close_case({.seed = 5, .noise = chips});
  EXPECT_TRUE(nothing.closure.effects.empty());
  EXPECT_FALSE(nothing.closure.outliers.empty());
  const testing::ClosureOutcome hidden = close_case({.seed = 5, .effects = {"linear_scale:X"}, .noise = chips});
  EXPECT_TRUE(hidden.found("linear_scale:X"));
}

TEST(Closure, SaysWhatTheDataCannotTest) {
  const testing::ClosureOutcome outcome = close_case({.seed = 7});
  std::vector<std::string> ids;
  for (const Untestable& u : outcome.closure.untestable) {
    ids.push_back(u.id);
    EXPECT_FALSE(u.separate_by.empty()) << u.id;
  }
  EXPECT_THAT(ids, ::testing::IsSupersetOf({"payload_sag", "brake_clamp"}));
}

}  // namespace
}  // namespace trunnion
