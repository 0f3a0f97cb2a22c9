#include "testpiece/prediction_spread.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "model/effects/location_errors.h"
#include "model/effects/rotary_error_map.h"
#include "support/noise.h"
#include "testpiece/pieces.h"

namespace trunnion {
namespace {

/// Location errors known to 1 um and 5 urad, correlated.
Model uncertain_locations() {
  const EffectPtr zero = make_location_errors(effect_context(trunnion_machine()));
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(8, 8);
  Eigen::VectorXd values(8);
  for (Eigen::Index i = 0; i < 8; ++i) {
    const double scale = zero->parameters()[static_cast<std::size_t>(i)].unit == Unit::um ? 1e-3 : 5e-6;
    covariance(i, i) = scale * scale;
    values[i] = 3 * scale * std::cos(1.7 * static_cast<double>(i));
  }
  covariance(0, 4) = covariance(4, 0) = 0.6e-6;
  return {.effects = {zero->with_parameters(values, covariance)}};
}

struct Cut {
  TestPiece piece = usual_piece(15, 10);
  KinematicChain chain{trunnion_machine()};
  std::vector<ToolPosition> path = flank_milling_path(piece, chain, {.steps_per_turn = 360});
  SurfaceGrid surface = evaluated_surface(piece);
  std::vector<double> deviation(const Model& model) const {
    return first_order_deviation_mm(piece, surface, path, actual_tools(path, chain, model, Length()));
  }
};

TEST(PredictionSpread, LinearStandardDeviationIsThatOfThePerturbedPrediction) {
  const Cut cut;
  const Model model = uncertain_locations();
  const std::vector<double> sd = DeviationSpread(cut.piece, cut.surface, cut.path, cut.chain, model).deviation_sd_mm();
  // J by central differences of the whole prediction.
  const EffectPtr effect = model.effects[0];
  Eigen::MatrixXd jacobian(static_cast<Eigen::Index>(sd.size()), 8);
  for (Eigen::Index i = 0; i < 8; ++i) {
    const double step = effect->parameters()[static_cast<std::size_t>(i)].unit == Unit::um ? 1e-4 : 1e-6;
    Eigen::VectorXd up = effect->values(), down = up;
    up[i] += step, down[i] -= step;
    const std::vector<double> a = cut.deviation({.effects = {effect->with_parameters(up, {})}});
    const std::vector<double> b = cut.deviation({.effects = {effect->with_parameters(down, {})}});
    for (std::size_t k = 0; k < sd.size(); ++k) jacobian(static_cast<Eigen::Index>(k), i) = (a[k] - b[k]) / 2 / step;
  }
  const Eigen::MatrixXd covariance = jacobian * effect->covariance() * jacobian.transpose();
  for (std::size_t k = 0; k < sd.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    EXPECT_NEAR(sd[k], std::sqrt(covariance(i, i)), 2e-6);
  }
}

TEST(PredictionSpread, DrawsSpreadAsTheLinearPartDoesWhereThePieceIsLinear) {
  const Cut cut;
  const Model model = uncertain_locations();
  const DeviationSpread spread(cut.piece, cut.surface, cut.path, cut.chain, model);
  const PredictionSpread found = spread.around(cut.deviation(model), {.draws = 4000, .seed = 11});
  // The size is linear in the deviations; EY0A alone makes -1.81 um a um, and it is not alone.
  const double low = found.heights[1].diameter_mm.low, high = found.heights[1].diameter_mm.high;
  EXPECT_NEAR((high - low) / found.heights[1].diameter_mm.sd, 2 * 1.96, 0.2);
  const ConeEvaluation center =
      evaluate_cone(traces_of(cut.piece, cut.surface, cut.deviation(model)), cut.piece.cone.half_angle);
  EXPECT_NEAR((high + low) / 2, center.heights[1].diameter_mm, 0.1 * found.heights[1].diameter_mm.sd);
  EXPECT_GT(center.heights[1].lsc_mm, found.heights[1].lsc_mm.low);
  EXPECT_LT(center.heights[1].lsc_mm, found.heights[1].lsc_mm.high);
  EXPECT_GT(found.heights[1].lsc_mm.sd, 0.1e-3);
  ASSERT_TRUE(found.half_angle_rad && found.axis_tilt_rad);
  EXPECT_GT(found.axis_tilt_rad->sd, 1e-6);
}

/// The same by whole predictions, each of a machine drawn from the covariance: what the draws must agree with, for the
/// roundness about every circle, which is linear in nothing.
TEST(PredictionSpread, OfEveryRoundnessIsThatOfWholePredictionsOfDrawnMachines) {
  constexpr int kMachines = 1000;
  constexpr double kAgreement = 0.12;  // five standard errors of a standard deviation from 1000 draws
  Cut cut;
  cut.piece.points = 72;
  cut.surface = evaluated_surface(cut.piece);
  const Model model = uncertain_locations();
  const EffectPtr effect = model.effects[0];
  const PredictionSpread found = DeviationSpread(cut.piece, cut.surface, cut.path, cut.chain, model)
                                     .around(cut.deviation(model), {.draws = 4000, .seed = 5});
  // The covariance is diagonal but for one pair; its root by hand.
  const Eigen::MatrixXd covariance = effect->covariance();
  Eigen::MatrixXd root = covariance.diagonal().cwiseSqrt().asDiagonal();
  root(4, 0) = covariance(4, 0) / root(0, 0);
  root(4, 4) = std::sqrt(covariance(4, 4) - root(4, 0) * root(4, 0));
  testing::Noise noise(8);
  std::array<std::vector<double>, 4> drawn;
  for (int k = 0; k < kMachines; ++k) {
    Eigen::VectorXd z(8);
    for (double& v : z) v = noise.normal();
    const Model one{.effects = {effect->with_parameters(effect->values() + root * z, {})}};
    const HeightEvaluation at =
        evaluate_cone(traces_of(cut.piece, cut.surface, cut.deviation(one)), cut.piece.cone.half_angle).heights[1];
    const double circles[] = {at.lsc_mm, at.mzc_mm, at.mic_mm, at.mcc_mm};
    for (std::size_t c = 0; c < 4; ++c) drawn[c].push_back(circles[c]);
  }
  const HeightSpread& height = found.heights[1];
  const DrawnSpread* said[] = {&height.lsc_mm, &height.mzc_mm, &height.mic_mm, &height.mcc_mm};
  for (std::size_t c = 0; c < 4; ++c) {
    double mean = 0, square = 0;
    for (const double v : drawn[c]) mean += v / kMachines;
    for (const double v : drawn[c]) square += (v - mean) * (v - mean) / (kMachines - 1);
    EXPECT_NEAR(said[c]->sd / std::sqrt(square), 1, kAgreement) << "circle " << c;
    std::ranges::sort(drawn[c]);
    EXPECT_NEAR(said[c]->low, drawn[c][kMachines / 40], 0.5 * said[c]->sd) << "circle " << c;
    EXPECT_NEAR(said[c]->high, drawn[c][kMachines - 1 - kMachines / 40], 0.5 * said[c]->sd) << "circle " << c;
  }
}

TEST(PredictionSpread, DependsOnTheSeedAndNotOnTheThreads) {
  const Cut cut;
  const Model model = uncertain_locations();
  const DeviationSpread spread(cut.piece, cut.surface, cut.path, cut.chain, model);
  const std::vector<double> deviation = cut.deviation(model);
  const auto lsc = [&](std::uint64_t seed, unsigned threads) {
    return spread.around(deviation, {.draws = 150, .seed = seed, .threads = threads}).heights[0].lsc_mm.sd;
  };
  EXPECT_EQ(lsc(3, 1), lsc(3, 4));
  EXPECT_NE(lsc(3, 1), lsc(4, 1));
}

TEST(PredictionSpread, WhatTheInterpolationMayMissCounts) {
  const Cut cut;
  RotaryMapContent content{.grid = zero_grid({Angle::degrees(-90), Angle::degrees(-45), Angle()},
                                             {Angle(), Angle::degrees(90), Angle::degrees(180), Angle::degrees(270)}),
                           .interpolation_sigma_mm = 1e-3};
  const Model model{.effects = {std::make_shared<RotaryErrorMap>(content, effect_context(trunnion_machine()))}};
  const DeviationSpread spread(cut.piece, cut.surface, cut.path, cut.chain, model);
  ASSERT_FALSE(spread.empty());
  for (const double sd : spread.deviation_sd_mm()) EXPECT_NEAR(sd, 1e-3, 1e-9);  // the normal is a unit vector
  const PredictionSpread found = spread.around(cut.deviation(model), {.draws = 500});
  EXPECT_GT(found.heights[0].lsc_mm.low, 0.2e-3);
  EXPECT_LT(found.heights[0].lsc_mm.high, 10e-3);
}

TEST(PredictionSpread, IsEmptyForAModelWithoutUncertainty) {
  const Cut cut;
  EXPECT_TRUE(DeviationSpread(cut.piece, cut.surface, cut.path, cut.chain, Model{}).empty());
}

TEST(PredictionSpread, TheFilterNarrowsWhatIsDrawnAsWell) {
  const Cut cut;
  const Model model = uncertain_locations();
  const DeviationSpread spread(cut.piece, cut.surface, cut.path, cut.chain, model);
  const std::vector<double> deviation = cut.deviation(model);
  const double open = spread.around(deviation, {.draws = 100}).heights[0].lsc_mm.high;
  const double closed =
      spread.around(deviation, {.draws = 100, .evaluation = {.filter_upr = 2}}).heights[0].lsc_mm.high;
  EXPECT_LT(closed, 0.8 * open);
}

}  // namespace
}  // namespace trunnion
