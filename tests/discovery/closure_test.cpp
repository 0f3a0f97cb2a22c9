#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "discovery/closure_case.h"
#include "discovery/inventions.h"
#include "identification/as_observations.h"

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

TEST(Closure, ReachesTheNoiseForEffectsOfNoCatalogueWithoutHarm) {
  for (const testing::Invention& invention : testing::inventions()) {
    if (invention.name != "dent of a way" && invention.name != "coolant" && invention.name != "twisted column")
      continue;
    const testing::ClosureOutcome outcome = close_case(
        {.seed = 2, .invention = &invention, .measured = testing::Measured::three_passes, .noncentrality = 230});
    ASSERT_FALSE(outcome.closure.effects.empty()) << invention.name;
    EXPECT_TRUE(outcome.closure.effects[0].smooth) << invention.name << ": no entry of the catalogue fits it";
    EXPECT_LT(outcome.closure.after.rms_um, 1.15 * 0.175) << invention.name;
    EXPECT_LT(outcome.closure.after.holdout_rms_um, outcome.closure.before.holdout_rms_um) << invention.name;
    EXPECT_LT(map_error_um(outcome.closure.model, outcome), 1.1 * map_error_um(outcome.closure.bare_model, outcome))
        << invention.name;
  }
}

TEST(Closure, FindsATurnOfTheTiltThatDependsOnItsSenseAndItsAngle) {
  const auto& all = testing::inventions();
  const auto snaps = std::ranges::find(all, "tilt that snaps", &testing::Invention::name);
  ASSERT_NE(snaps, all.end());
  const testing::ClosureOutcome outcome = close_case(
      {.seed = 5, .invention = &*snaps, .measured = testing::Measured::three_passes_verified, .noncentrality = 410});
  ASSERT_EQ(outcome.closure.effects.size(), 1U);
  EXPECT_EQ(outcome.closure.effects[0].effect->id(), "smooth:A_dir,A_deg");
  EXPECT_LT(map_error_um(outcome.closure.model, outcome), 0.8 * map_error_um(outcome.closure.bare_model, outcome));
}

TEST(Closure, SeeksNothingOfTheMachineInAColumnThatActsOnTheMeasurement) {
  // The draught bends the probe in side touches alone: along the approach, but for its part along Z.
  const auto& all = testing::inventions();
  const auto draught = std::ranges::find(all, "draught on the probe", &testing::Invention::name);
  ASSERT_NE(draught, all.end());
  const testing::ClosureOutcome outcome = close_case(
      {.seed = 2, .invention = &*draught, .measured = testing::Measured::three_passes_verified, .noncentrality = 410});
  ASSERT_EQ(outcome.closure.effects.size(), 2U);
  for (const AcceptedEffect& e : outcome.closure.effects) {
    EXPECT_EQ(e.effect->id(), "smooth:draught");
    EXPECT_EQ(e.effect->origin(), Origin::measurement);
  }
}

TEST(Closure, NamesASquarenessAsSuchThoughASmoothEffectWouldDo) {
  const testing::ClosureOutcome outcome = close_case(
      {.seed = 3, .effects = {"squareness:XZ"}, .measured = testing::Measured::three_passes, .noncentrality = 400});
  ASSERT_EQ(outcome.closure.effects.size(), 1U);
  EXPECT_EQ(outcome.closure.effects[0].effect->id(), "squareness:XZ");
}

TEST(Closure, TakesACrowdOfFarTouchesForASlipAndNotForChips) {
  // Many readings of one body stand far off after one moment; leaving them out would explain them as well.
  const testing::ClosureOutcome outcome = close_case(
      {.seed = 4, .effects = {"artifact_slip:2"}, .measured = testing::Measured::three_passes, .noncentrality = 5000});
  EXPECT_TRUE(outcome.found("artifact_slip:2"));
  EXPECT_LT(outcome.closure.outliers.size(), 4U);
  EXPECT_EQ(outcome.closure.verdict, Verdict::explained);
}

TEST(Closure, TellsTwoEffectsFromOneAnother) {
  const testing::ClosureOutcome outcome = close_case({.seed = 5,
                                                      .effects = {"squareness:XY", "backlash:C"},
                                                      .measured = testing::Measured::three_passes,
                                                      .noncentrality = 100});
  EXPECT_EQ(outcome.closure.effects.size(), 2U);
  EXPECT_TRUE(outcome.found("squareness:XY") && outcome.found("backlash:C"));
}

/// An encoder on the table, C turning slowly up and down: a map of two harmonics, a backlash, ninety teeth.
ObservationSet encoder_log(std::size_t rows) {
  testing::Noise noise(4);
  std::vector<testing::ObservationRow> log;
  for (std::size_t i = 0; i < rows; ++i) {
    const std::size_t quarter = i * 4 / rows;
    const double share = static_cast<double>(i * 4 % rows) / static_cast<double>(rows);
    testing::ObservationRow row{
        .kind = "rotation", .C_deg = 360 * (quarter % 2 == 0 ? share : 1 - share), .artifact = "enc"};
    const double c = row.C_deg * std::numbers::pi / 180;
    row.m = Eigen::Vector3d::UnitZ();
    row.value_urad =
        8 * std::cos(c) + 3 * std::sin(2 * c) + 6 * std::cos(90 * c) + (quarter % 2 == 0 ? 0 : 12) + noise.normal();
    row.time_s = static_cast<double>(i) * .1;
    row.C_dir = quarter % 2 == 0 ? 1 : -1;
    log.push_back(row);
  }
  ObservationSet set = testing::as_observations(log, "log.csv");
  for (Observation& o : set.rows) o.sigma = 1e-6;
  set.has_sigma = true;
  return set;
}

TEST(Closure, FindsWhatAnEncoderLogHolds) {
  const ObservationSet log = encoder_log(2000);
  for (const std::size_t most : {std::size_t{8000}, std::size_t{900}}) {
    const ClosureResult closure = close_loop(log, log.rows.size(), testing::plain_machine(), {.most_readings = most});
    EXPECT_EQ(closure.thinned != nullptr, most < 1500);
    EXPECT_LE(closure.problem.readings.size(), most);
    ASSERT_EQ(closure.effects.size(), 2U);
    EXPECT_EQ(closure.verdict, Verdict::explained);
    for (const AcceptedEffect& e : closure.effects) {
      const bool backlash = e.effect->id() == "backlash:C";
      EXPECT_TRUE(backlash || e.effect->id() == "cyclic_error:C:90") << e.effect->id();
      const double wanted = backlash ? 12e-6 : 6e-6;
      EXPECT_NEAR(e.effect->values()[0], wanted, 5 * std::sqrt(e.effect->covariance()(0, 0)));
      EXPECT_LT(std::sqrt(e.effect->covariance()(0, 0)), 0.2e-6);
    }
  }
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
