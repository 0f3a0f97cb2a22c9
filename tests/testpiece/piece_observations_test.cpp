#include "io/piece_observations.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "error.h"
#include "identification/linear_problem.h"
#include "linear_algebra/factors.h"
#include "testpiece/measured.h"
#include "testpiece/pieces.h"
#include "testpiece/told_errors.h"

namespace trunnion {
namespace {

constexpr double kFirstOrder_mm = 0.06e-3;  // 0.05 um of the cut, and what first order leaves of errors of some um

struct ObservedCut {
  TestPiece piece;
  KinematicChain chain{trunnion_machine()};
  std::vector<ToolPosition> path;
  SurfaceGrid surface;
  explicit ObservedCut(TestPiece p) : piece(std::move(p)) {
    path = flank_milling_path(piece, chain, {.steps_per_turn = 1800});
    surface = evaluated_surface(piece);
  }
  PieceObservations observed(const MeasuredPiece& measured, const Situation& known = {}) const {
    return observations_of({piece, measured, path, chain, known});
  }
};

TestPiece leaning_piece(int points) {
  TestPiece piece = usual_piece(15, 30);
  piece.points = points;
  piece.heights = {Length::millimetres(2), Length::millimetres(18)};
  piece.tool.length = Length::millimetres(120);
  piece.feed_mm_per_min = 400;
  return piece;
}

/// Coefficients of the measurement's unknowns, a row a reading.
Eigen::MatrixXd unknown_columns(const LinearProblem& problem) {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(problem.readings.size()),
                                                  static_cast<Eigen::Index>(problem.unknowns.size()));
  for (std::size_t i = 0; i < problem.readings.size(); ++i)
    for (const auto& [u, coefficient] : problem.terms_of(problem.readings[i]))
      columns(static_cast<Eigen::Index>(i), u) += coefficient;
  return columns;
}

/// Each reading is what the effect says it is in its situation: senses of motion, time, covariates.
TEST(PieceObservations, AreLinearInEveryEffectOfTheMachine) {
  const ObservedCut cut(leaning_piece(48));
  const std::vector<std::string> names = {"load_kg", "A_clamped"};
  const std::vector<double> values = {20, 1};
  const Situation known{.temperature_C = 22, .extra = {&names, values.data()}};
  testing::Noise noise(1);
  for (const ToldError& told : told_errors()) {
    testing::VirtualMachine machine = testing::perfect_machine("w C' A' Y' b X Z t");
    told.add(machine);
    const std::vector<double> left =
        cut_by_brute_force(machine, cut.piece, cut.surface, cut.path, [&](testing::MachineState& state) {
          state.temperature_C = 22;
          for (std::size_t k = 0; k < names.size(); ++k) state.covariates[names[k]] = values[k];
        });
    const MeasuredPiece found = measured(cut.surface, left, {.sigma_mm = 1e-6}, noise);
    const PieceObservations observed = cut.observed(found, known);
    const LinearProblem problem = make_linear_problem(observed.set, trunnion_machine());
    const EffectPtr effect = read_effect(told.entry, effect_context(trunnion_machine()));
    double most = 0;
    for (const Reading& reading : problem.readings) {
      const double told_mm = reading.functional.dot(effect->at(problem.situations[reading.row]).vector());
      EXPECT_NEAR(reading.value, told_mm, kFirstOrder_mm)
          << told.entry["id"] << " at line " << observed.set.rows[reading.row].line;
      most = std::max(most, std::abs(reading.value));
    }
    EXPECT_GT(most, 0.2e-3) << told.entry["id"];
    EXPECT_GT(problem.readings.size(), 70U);  // of 96 points some lie at reversals
  }
}

TEST(PieceObservations, SetUpAndSizeAreUnknownsAsFarAsTheShapeShowsThem) {
  for (const auto& [half_angle, shown] : {std::pair{15.0, 5}, {0.0, 5}}) {
    TestPiece piece = leaning_piece(72);
    piece.cone.half_angle = Angle::degrees(half_angle);
    const ObservedCut cut(piece);
    testing::Noise noise(2);
    const MeasuredPiece found = measured(
        cut.surface, std::vector<double>(cut.surface.points.size(), 0.0),
        {.sigma_mm = 1e-9, .shift_mm = {5e-3, -3e-3, 4e-3}, .turn_rad = {20e-6, -30e-6, 40e-6}, .grown_mm = 2e-3},
        noise);
    const PieceObservations observed = cut.observed(found);
    const LinearProblem problem = make_linear_problem(observed.set, trunnion_machine());
    EXPECT_EQ(problem.unknowns.size(), static_cast<std::size_t>(shown));
    Eigen::VectorXd y(static_cast<Eigen::Index>(problem.readings.size()));
    for (Eigen::Index i = 0; i < y.size(); ++i) y[i] = problem.readings[static_cast<std::size_t>(i)].value;
    const Eigen::MatrixXd x = unknown_columns(problem);
    const LeastSquares solver(x);
    EXPECT_EQ(solver.rank(), shown);
    EXPECT_GT(y.cwiseAbs().maxCoeff(), 3e-3);
    EXPECT_LT((y - x * solver.solve(y)).cwiseAbs().maxCoeff(), 1e-6);
  }
}

TEST(PieceObservations, StandBesideTheProbingInStretchesOfTheirOwn) {
  const ObservedCut cut(leaning_piece(72));
  testing::Noise noise(3);
  MeasuredPiece found =
      measured(cut.surface, std::vector<double>(cut.surface.points.size(), 0.0), {.sigma_mm = 0.2e-3}, noise);
  found.columns = {"spindle_C"};
  found.values.assign(found.points.size(), 31);
  const PieceObservations observed = cut.observed(found);
  EXPECT_FALSE(observed.sigma_told);
  EXPECT_NEAR(observed.sigma_mm, 0.2e-3, 0.04e-3);
  EXPECT_GT(observed.unsteady, 0U);
  EXPECT_EQ(observed.unsteady + observed.set.rows.size(), found.points.size());

  ObservationSet probing{.files = {"o.csv"}, .extra_columns = {"load_kg"}, .extra_values = {7}};
  probing.rows.push_back({.kind = ReadingKind::rotation, .direction = Eigen::Vector3d::UnitZ(), .sigma = 1e-6});
  const ObservationSet both = joined_with_piece(probing, observed.set);
  EXPECT_EQ(both.extra_columns, (std::vector<std::string>{"load_kg", "spindle_C"}));
  EXPECT_TRUE(both.has_time);
  const std::vector<Situation> at = situations(both);
  EXPECT_EQ(at[0].covariate("load_kg"), 7);
  EXPECT_EQ(at[0].covariate("spindle_C"), 0);
  EXPECT_EQ(at[1].covariate("load_kg"), 0);
  EXPECT_EQ(at[1].covariate("spindle_C"), 31);
  EXPECT_EQ(at[1].reading, ReadingKind::none);
  EXPECT_EQ(at[1].tool_length_mm, 120);
  EXPECT_EQ(both.place(1), "piece.csv:" + std::to_string(observed.set.rows[0].line));
  const std::vector<PoseGroup> groups = pose_groups(both);
  EXPECT_FALSE(groups.front().moving);
  EXPECT_EQ(groups.size(), 25U);  // the probed pose, and 24 stretches
  EXPECT_TRUE(groups.back().moving);
  // The path goes on from row to row.
  for (std::size_t r = 2; r < both.rows.size(); ++r) EXPECT_GE(both.rows[r].time_s, both.rows[r - 1].time_s);
}

TEST(PieceObservations, LeaveOutWhatAReversalHasPartIn) {
  const ObservedCut cut(leaning_piece(360));
  testing::Noise noise(4);
  const MeasuredPiece found =
      measured(cut.surface, std::vector<double>(cut.surface.points.size(), 0.0), {.sigma_mm = 0.2e-3}, noise);
  const PieceObservations observed = cut.observed(found);
  EXPECT_LT(static_cast<double>(observed.unsteady), 0.12 * static_cast<double>(found.points.size()));
  for (const Observation& row : observed.set.rows) {
    // Neighbours of a row that was kept turn the same way as it does.
    const double phi = found.points[row.line - 2].phi.in_radians();
    for (const ToolPosition& p : cut.path) {
      if (std::abs(std::remainder(p.phi_rad - phi, 2 * std::numbers::pi)) < 0.005) {
        EXPECT_EQ(p.turn_sense, row.turn_sense);
      }
    }
  }
}

TEST(PieceObservations, WantNoiseThatCanBeTold) {
  const ObservedCut cut(leaning_piece(48));
  testing::Noise noise(5);
  MeasuredPiece found = measured(cut.surface, std::vector<double>(cut.surface.points.size(), 0.0), {}, noise);
  EXPECT_THROW(cut.observed(found), InputError);
  for (MeasuredPoint& point : found.points) point.sigma_mm = 0.3e-3;
  EXPECT_TRUE(cut.observed(found).sigma_told);
  EXPECT_NEAR(cut.observed(found).sigma_mm, 0.3e-3, 1e-12);
}

}  // namespace
}  // namespace trunnion
