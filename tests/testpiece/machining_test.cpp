#include "testpiece/machining.h"

#include <gtest/gtest.h>

#include <cmath>

#include "error.h"
#include "model/effects/rotary_error_map.h"
#include "support/smooth_machine.h"
#include "support/undeclared_effects.h"
#include "testpiece/function_effect.h"
#include "testpiece/independent_cut.h"
#include "testpiece/pieces.h"
#include "units/angle.h"

namespace trunnion {
namespace {

constexpr double kZero_mm = 1e-9;       // 1e-6 um: nothing wrong, nothing seen
constexpr double kSmooth_mm = 0.02e-3;  // what first order may leave of smooth errors
constexpr double kIndependent_mm = 0.05e-3;

struct Setting {
  TestPiece piece;
  KinematicChain chain{trunnion_machine()};
  std::vector<ToolPosition> path;
  SurfaceGrid surface;
};

Setting setting(TestPiece piece, int steps_per_turn = 3600) {
  Setting s{.piece = std::move(piece)};
  s.path = flank_milling_path(s.piece, s.chain, {.steps_per_turn = steps_per_turn});
  s.surface = evaluated_surface(s.piece);
  return s;
}

std::vector<ToolInWorkpiece> nominal_tools(const Setting& s) {
  return actual_tools(s.path, s.chain, Model{}, s.piece.tool.length);
}

double largest(const std::vector<double>& values) {
  double most = 0;
  for (const double v : values) most = std::max(most, std::abs(v));
  return most;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

std::vector<double> cut_by_brute_force(const testing::VirtualMachine& machine, const Setting& s) {
  return cut_by_brute_force(machine, s.piece, s.surface, s.path);
}

/// The map that a perfect calibration of the machine gives.
Model model_of(const testing::VirtualMachine& machine) {
  std::vector<double> a_deg, c_deg;
  for (double a = -90; a <= 0; a += 5) a_deg.push_back(a);
  for (double c = 0; c < 360; c += 24) c_deg.push_back(c);
  const testing::GaugedMaps maps = testing::gauged_maps(machine, a_deg, c_deg);
  std::vector<Angle> a, c;
  for (const double v : a_deg) a.push_back(Angle::degrees(v));
  for (const double v : c_deg) c.push_back(Angle::degrees(v));
  RotaryMapContent content{.grid = zero_grid(a, c)};
  for (std::size_t i = 0; i < a.size(); ++i)
    content.grid.tilt[i] = {maps.tilt[i].translation_mm, maps.tilt[i].rotation_rad};
  for (std::size_t i = 0; i < maps.C.size(); ++i)
    content.grid.turn[i] = {maps.C[i].translation_mm, maps.C[i].rotation_rad};
  return {.effects = {std::make_shared<RotaryErrorMap>(content, effect_context(trunnion_machine()))}};
}

TestPiece few_points(double half_angle_deg, double tilt_deg) {
  TestPiece piece = usual_piece(half_angle_deg, tilt_deg);
  piece.points = 24;
  return piece;
}

TEST(Machining, WithoutErrorsNothingIsLeftAndNothingMissing) {
  for (const auto& [half_angle, tilt] : {std::pair{15.0, 10.0}, {45, 30}, {15, 15}, {15, 30}, {0, 20}, {30, 0}})
    for (const double corner : {0.0, 3.0, 10.0}) {
      TestPiece piece = usual_piece(half_angle, tilt);
      piece.points = 90;
      piece.cone.tilt_azimuth = Angle::degrees(65);
      piece.tool.corner_radius = Length::millimetres(corner);
      piece.tool.overhang = Length::millimetres(corner + 1);
      const Setting s = setting(piece, 1800);
      const std::vector<ToolInWorkpiece> tools = nominal_tools(s);
      EXPECT_LT(largest(first_order_deviation_mm(piece, s.surface, s.path, tools)), kZero_mm);
      EXPECT_LT(largest(envelope_deviation_mm(piece, s.surface, tools)), kZero_mm)
          << half_angle << " deg tilted " << tilt << " deg, corner " << corner;
    }
}

TEST(Machining, AgreesWithAnIndependentCutForSmoothErrors) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const testing::VirtualMachine machine = testing::smooth_machine(seed);
    const Model model = model_of(machine);
    for (const auto& [half_angle, tilt] : {std::pair{15.0, 10.0}, {45, 30}, {15, 30}}) {
      const Setting s = setting(few_points(half_angle, tilt));
      const auto tools = actual_tools(s.path, s.chain, model, Length());
      const std::vector<double> cut = envelope_deviation_mm(s.piece, s.surface, tools);
      EXPECT_LT(largest_difference(cut, cut_by_brute_force(machine, s)), kIndependent_mm) << seed << " tilt " << tilt;
      EXPECT_GT(largest(cut), 5e-3);
    }
  }
}

/// A bull-nose and a ball whose round ends stand just below the flank, or reach into it.
TEST(Machining, AgreesWithAnIndependentCutForRoundedToolsOnASmoothMachine) {
  const testing::VirtualMachine machine = testing::smooth_machine(4);
  const Model model = model_of(machine);
  for (const double corner : {3.0, 10.0})
    for (const double overhang : {corner - 1, corner + 0.5}) {
      TestPiece piece = few_points(15, 10);
      piece.tool.corner_radius = Length::millimetres(corner);
      piece.tool.overhang = Length::millimetres(overhang);
      piece.heights = {Length::millimetres(0.2), Length::millimetres(10)};
      const Setting s = setting(piece);
      const std::vector<double> cut =
          envelope_deviation_mm(piece, s.surface, actual_tools(s.path, s.chain, model, Length()));
      EXPECT_LT(largest_difference(cut, cut_by_brute_force(machine, s)), kIndependent_mm)
          << "corner " << corner << ", overhang " << overhang;
      EXPECT_GT(largest(cut), overhang < corner ? 0.02 : 5e-3);
    }
}

TEST(Machining, FirstOrderIsEnoughForSmoothErrors) {
  const testing::SmoothMachineOptions fair{
      .translation_mm = 1e-3, .rotation_rad = 5e-6, .location_mm = 3e-3, .location_rad = 10e-6};
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6}) {
    const Model model = model_of(testing::smooth_machine(seed, fair));
    for (const auto& [half_angle, tilt] : {std::pair{15.0, 10.0}, {45, 30}, {15, 30}}) {
      const Setting s = setting(usual_piece(half_angle, tilt));
      const auto tools = actual_tools(s.path, s.chain, model, Length());
      const std::vector<double> cut = envelope_deviation_mm(s.piece, s.surface, tools);
      EXPECT_LT(largest_difference(cut, first_order_deviation_mm(s.piece, s.surface, s.path, tools)), kSmooth_mm)
          << "seed " << seed << " tilt " << tilt << ", errors up to " << largest(cut) << " mm";
      EXPECT_GT(largest(cut), 3e-3);
    }
  }
}

TEST(Machining, AgreesWithAnIndependentCutForBacklash) {
  constexpr double kWidth_rad = 40e-6;
  testing::VirtualMachine machine = testing::perfect_machine("w C' A' Y' b X Z t");
  testing::add_rotary_backlash(machine, 'A', kWidth_rad);
  testing::add_rotary_backlash(machine, 'C', kWidth_rad);
  Model model;
  for (const char* id : {"backlash:A", "backlash:C"}) {
    const std::string text = id;
    const EffectContext context = effect_context(trunnion_machine());
    model.effects.push_back(family_of(text)
                                .candidates({.context = context, .readings = {}, .columns = {}, .artifacts = {}})
                                .at(text.back() == 'A' ? 0 : 1)
                                ->with_parameters(Eigen::VectorXd::Constant(1, -kWidth_rad), {}));
    ASSERT_EQ(model.effects.back()->id(), text);
  }
  for (const double tilt : {10.0, 30.0}) {
    TestPiece piece = few_points(15, tilt);
    piece.points = 72;
    const Setting s = setting(piece);
    const std::vector<double> cut =
        envelope_deviation_mm(s.piece, s.surface, actual_tools(s.path, s.chain, model, Length()));
    EXPECT_LT(largest_difference(cut, cut_by_brute_force(machine, s)), kIndependent_mm) << tilt;
    EXPECT_GT(largest(cut), 1e-3);
  }
}

TEST(Machining, AgreesWithAnIndependentCutForRipple) {
  testing::VirtualMachine machine = testing::perfect_machine("w C' A' Y' b X Z t");
  machine.workpiece_effects = {[](const testing::MachineState& state) {
    return testing::error_transform(testing::um_urad(3 * std::cos(60 * state.rotary.C_rad), 0, 0, 0, 0, 0));
  }};
  // The workpiece was set up at C = 0, where the ripple stands at its crest.
  const Model model{.effects = {std::make_shared<FunctionEffect>([](const Situation& at) {
                      return PoseError{.translation_mm = {3e-3 * std::cos(60 * at.at.c.in_radians()), 0, 0}};
                    })}};
  const Setting s = setting(few_points(15, 10), 7200);
  const std::vector<double> cut =
      envelope_deviation_mm(s.piece, s.surface, actual_tools(s.path, s.chain, model, Length()));
  std::vector<double> independent = cut_by_brute_force(machine, s);
  // The machine's own ripple at the set-up pose moves the workpiece as a whole: take that off.
  for (std::size_t i = 0; i < independent.size(); ++i)
    independent[i] -= s.surface.points[i].normal_w.dot(Eigen::Vector3d(3e-3, 0, 0));
  EXPECT_LT(largest_difference(cut, independent), kIndependent_mm);
  EXPECT_GT(largest(cut), 1e-3);
}

TEST(Machining, LeavesTheFilletOfARoundedToolThatIsHeldTooHigh) {
  const testing::VirtualMachine perfect = testing::perfect_machine("w C' A' Y' b X Z t");
  for (const double corner : {3.0, 10.0}) {
    TestPiece piece = few_points(15, 10);
    piece.tool.corner_radius = Length::millimetres(corner);
    piece.tool.overhang = Length::millimetres(-1);
    piece.heights = {Length::millimetres(1.5), Length::millimetres(2.5), Length::millimetres(18)};
    const Setting s = setting(piece);
    const std::vector<double> cut = envelope_deviation_mm(piece, s.surface, nominal_tools(s));
    std::vector<double> independent = cut_by_brute_force(perfect, s);
    for (std::size_t i = 0; i < cut.size(); ++i) {
      if (independent[i] < 1)
        EXPECT_NEAR(cut[i], independent[i], 1e-6) << i;
      else
        EXPECT_GE(cut[i], 1);
    }
    EXPECT_GT(cut[0], 0.1);
    EXPECT_LT(std::abs(cut.back()), kZero_mm);
  }
}

TEST(Machining, ARigidlyDisplacedPieceStaysAsRoundAsItWas) {
  constexpr double kSecondOrder_mm = 0.02e-3;  // the way of 10 um times the slope of 30 um over 40 mm, at both ends
  const Setting s = setting(usual_piece(15, 10));
  std::vector<ToolInWorkpiece> tools = actual_tools(s.path, s.chain, model_of(testing::smooth_machine(5)), Length());
  const auto evaluated = [&](const std::vector<ToolInWorkpiece>& t) {
    return evaluate_cone(traces_of(s.piece, s.surface, envelope_deviation_mm(s.piece, s.surface, t)),
                         s.piece.cone.half_angle);
  };
  const ConeEvaluation before = evaluated(tools);
  const Eigen::Isometry3d moved =
      transform({.translation_mm = {5e-3, -6e-3, 3e-3}, .rotation_rad = {20e-6, -40e-6, 50e-6}});
  for (ToolInWorkpiece& tool : tools) tool = {moved * tool.tip_w_mm, moved.linear() * tool.axis_w};
  const ConeEvaluation after = evaluated(tools);
  for (std::size_t j = 0; j < before.heights.size(); ++j) {
    EXPECT_GT((after.heights[j].center_mm - before.heights[j].center_mm).norm(), 3e-3);
    EXPECT_NEAR(after.heights[j].lsc_mm, before.heights[j].lsc_mm, kSecondOrder_mm);
    EXPECT_NEAR(after.heights[j].mzc_mm, before.heights[j].mzc_mm, kSecondOrder_mm);
    EXPECT_NEAR(after.heights[j].mic_mm, before.heights[j].mic_mm, kSecondOrder_mm);
    EXPECT_NEAR(after.heights[j].mcc_mm, before.heights[j].mcc_mm, kSecondOrder_mm);
  }
  EXPECT_GT((*after.axis_tilt_rad - *before.axis_tilt_rad).norm(), 20e-6);
}

TEST(Machining, DoesNotDependOnTheNumberOfThreads) {
  const Setting s = setting(usual_piece(15, 10));
  const auto tools = actual_tools(s.path, s.chain, model_of(testing::smooth_machine(5)), Length(), {}, 1);
  EXPECT_EQ(envelope_deviation_mm(s.piece, s.surface, tools, 1), envelope_deviation_mm(s.piece, s.surface, tools, 5));
}

TEST(Machining, RefusesAPathThatDoesNotCutThePiece) {
  const Setting s = setting(few_points(15, 10), 360);
  std::vector<ToolInWorkpiece> tools = nominal_tools(s);
  for (ToolInWorkpiece& tool : tools) tool.tip_w_mm += 400 * Eigen::Vector3d::UnitZ();
  EXPECT_THROW(envelope_deviation_mm(s.piece, s.surface, tools), RangeError);
}

}  // namespace
}  // namespace trunnion
