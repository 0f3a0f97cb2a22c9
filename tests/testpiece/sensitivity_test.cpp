#include "testpiece/sensitivity.h"

#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "geometric_errors/rotary_errors.h"
#include "testpiece/function_effect.h"
#include "testpiece/pieces.h"
#include "testpiece/profile_filter.h"

namespace trunnion {
namespace {

using ::testing::ElementsAre;

/// Published roundness (LSC, um) near the base and near the top: two digits.
constexpr double kTwoDigits = 0.055;

std::map<std::string, Sensitivity> by_name(const TestPiece& piece, const SensitivityOptions& options = {}) {
  std::map<std::string, Sensitivity> found;
  for (const Sensitivity& s : sensitivities(piece, effect_context(trunnion_machine()), options))
    found.emplace(s.error, s);
  return found;
}

struct Published {
  const char* error;
  double low_um, high_um;
};

void expect_roundness(double half_angle, double tilt, const std::vector<Published>& rows) {
  const auto found = by_name(usual_piece(half_angle, tilt));
  for (const Published& row : rows) {
    const Sensitivity& s = found.at(row.error);
    const double tolerance = row.low_um < 1 && row.high_um < 1 ? 0.0055 : kTwoDigits;
    EXPECT_NEAR(s.shown.heights.front().lsc_mm * 1e3, row.low_um, tolerance)
        << row.error << " on " << half_angle << '/' << tilt;
    EXPECT_NEAR(s.shown.heights.back().lsc_mm * 1e3, row.high_um, tolerance)
        << row.error << " on " << half_angle << '/' << tilt;
  }
}

TEST(Sensitivities, OfLocationErrorsAreThePublishedOnes) {
  expect_roundness(15, 10,
                   {{"EX0C", 6.5, 6.5},
                    {"EY0A", 3.0, 3.0},
                    {"EY0C", 3.0, 3.0},
                    {"EZ0A", 0, 0},
                    {"EA0C", .63, .88},
                    {"EB0A", 1.0, 1.6},
                    {"EC0A", 0, 0},
                    {"EB0C", 1.4, 1.9}});
  expect_roundness(45, 30,
                   {{"EX0C", 8.2, 8.2},
                    {"EY0A", 4.7, 4.7},
                    {"EY0C", 3.9, 3.9},
                    {"EZ0A", 0, 0},
                    {"EA0C", .41, .93},
                    {"EB0A", .23, .97},
                    {"EC0A", 0, 0},
                    {"EB0C", .8, 1.9}});
  expect_roundness(15, 30,
                   {{"EX0C", 6.2, 6.2},
                    {"EY0A", 5.5, 5.5},
                    {"EY0C", 6.1, 6.1},
                    {"EA0C", 1.3, 1.8},
                    {"EB0A", 1.5, 2.0},
                    {"EB0C", 1.9, 2.5}});
}

TEST(Sensitivities, OfRotationsGrowWithTheHeightAboveTheTable) {
  for (const auto& [z, ea0c, eb0a, eb0c] : {std::tuple{50.0, .74, 1.6, 1.6}, {150.0, 2.2, 4.9, 4.9}}) {
    TestPiece piece = usual_piece(15, 10);
    piece.cone.base_center_w_mm = {0, 0, z};
    const auto found = by_name(piece);
    EXPECT_NEAR(found.at("EA0C").shown.heights[1].lsc_mm * 1e3, ea0c, kTwoDigits);
    EXPECT_NEAR(found.at("EB0A").shown.heights[1].lsc_mm * 1e3, eb0a, kTwoDigits);
    EXPECT_NEAR(found.at("EB0C").shown.heights[1].lsc_mm * 1e3, eb0c, kTwoDigits);
  }
}

TEST(Sensitivities, OfTranslationsAreAlikeEverywhereAndOfRotationsVanishBesideTheAxes) {
  TestPiece piece = usual_piece(15, 10);
  const auto there = by_name(piece);
  piece.cone.base_center_w_mm = {0, 0, 0};
  const auto here = by_name(piece);
  for (const char* name : {"EX0C", "EY0A", "EY0C"})
    EXPECT_NEAR(here.at(name).shown.heights[1].lsc_mm, there.at(name).shown.heights[1].lsc_mm, 1e-6) << name;
  // At mid-height the point lies square to the tool from the axes' crossing.
  for (const char* name : {"EA0C", "EB0A", "EB0C"}) {
    EXPECT_LT(here.at(name).shown.heights[1].lsc_mm, 1e-6) << name;
    EXPECT_GT(here.at(name).shown.heights[2].lsc_mm, 1e-4) << name;
  }
}

TEST(Sensitivities, OfErrorMotionsAreThePublishedOnes) {
  const auto found = by_name(usual_piece(15, 10), {.length = Length::micrometres(5), .angle = Angle::microradians(20)});
  const auto middle = [&](const char* name) { return found.at(name).shown.heights[1].lsc_mm * 1e3; };
  EXPECT_NEAR(middle("EXC cos C"), 3.9, kTwoDigits);
  EXPECT_NEAR(middle("EXC cos 2C"), 5.0, kTwoDigits);
  EXPECT_NEAR(middle("EZC cos C"), .2, kTwoDigits);
  EXPECT_NEAR(middle("EZC cos 2C"), 2.1, kTwoDigits);
  EXPECT_NEAR(middle("EAC cos C"), .65, kTwoDigits);
  EXPECT_NEAR(middle("EBC sin C"), .65, kTwoDigits);
  EXPECT_NEAR(middle("ECC cos C"), 1.0, kTwoDigits);
  EXPECT_NEAR(middle("ECC cos 2C"), 1.2, kTwoDigits);
  EXPECT_EQ(found.size(), 8 + 6 * 3 + 6 * 6 + 2 + (3 + 3 + 6 * 2 + 9 + 3));  // the last of the linear axes
}

TEST(Sensitivities, OfBacklashAreStepsWhereAnAxisReverses) {
  const SensitivityOptions options{.angle = Angle::microradians(20)};
  const auto upright = by_name(usual_piece(15, 10), options), leaning = by_name(usual_piece(15, 30), options);
  EXPECT_NEAR(upright.at("backlash:A").shown.heights[1].lsc_mm * 1e3, 1.4, kTwoDigits);
  EXPECT_LT(upright.at("backlash:C").shown.heights[1].lsc_mm, 1e-5);  // C never reverses
  EXPECT_FALSE(upright.at("backlash:C").seen_in_roundness());
  EXPECT_GT(leaning.at("backlash:C").shown.heights[1].lsc_mm, 0.5e-3);
  EXPECT_TRUE(leaning.at("backlash:C").seen_in_roundness());
}

/// The traces of a piece cut with the given rotary errors, counted from A = C = 0 or not.
std::vector<ConeTrace> shown_traces(const TestPiece& piece, const std::function<RotaryErrors(IndexedPosition)>& errors,
                                    bool from_reference = true) {
  const auto chain = std::make_shared<KinematicChain>(trunnion_machine());
  const Model model{.effects = {std::make_shared<FunctionEffect>([=](const Situation& s) {
                      return relative_pose_error(*chain, s.at, errors(s.at),
                                                 from_reference ? errors({}) : RotaryErrors(), {});
                    })}};
  const auto path = flank_milling_path(piece, *chain, {.steps_per_turn = 360});
  const SurfaceGrid surface = evaluated_surface(piece);
  return traces_of(piece, surface,
                   first_order_deviation_mm(piece, surface, path, actual_tools(path, *chain, model, Length())));
}

/// What a machine with the given rotary errors shows of the usual piece.
ConeEvaluation shown(const std::function<RotaryErrors(IndexedPosition)>& errors, bool from_reference = true) {
  const TestPiece piece = usual_piece(15, 10);
  return evaluate_cone(shown_traces(piece, errors, from_reference), piece.cone.half_angle);
}

/// The roundness in mid-height of a piece cut with tip errors that are told as a function of the tip in R.
double shown_lsc_mm(const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& moved) {
  const TestPiece piece = usual_piece(15, 10);
  const KinematicChain chain(trunnion_machine());
  const Model model{.effects = {std::make_shared<FunctionEffect>(
                        [=](const Situation& s) { return PoseError{.translation_mm = moved(s.point_r_mm)}; })}};
  const auto path = flank_milling_path(piece, chain, {.steps_per_turn = 360});
  const SurfaceGrid surface = evaluated_surface(piece);
  return evaluate_cone(
             traces_of(piece, surface,
                       first_order_deviation_mm(piece, surface, path, actual_tools(path, chain, model, Length()))),
             piece.cone.half_angle)
      .heights[1]
      .lsc_mm;
}

TEST(Sensitivities, OfLinearAxesReachTheirAmountOnThePath) {
  const auto found = by_name(usual_piece(15, 10));
  Eigen::Vector3d most = Eigen::Vector3d::Zero();
  for (const ToolPosition& p : flank_milling_path(usual_piece(15, 10), KinematicChain(trunnion_machine())))
    most = most.cwiseMax(p.tip_r_mm.cwiseAbs());
  constexpr double kSampling_mm = 1e-6;  // the path's extreme is met to a degree of phi
  using Eigen::Vector3d;
  const std::map<std::string, std::function<Vector3d(const Vector3d&)>> motions = {
      {"EXX X", [&](const Vector3d& p) { return Vector3d(-10e-3 * p.x() / most.x(), 0, 0); }},
      {"EYY Y", [&](const Vector3d& p) { return Vector3d(0, -10e-3 * p.y() / most.y(), 0); }},
      {"EYX X^2", [&](const Vector3d& p) { return Vector3d(0, -10e-3 * std::pow(p.x() / most.x(), 2), 0); }},
      {"EXY Y^3", [&](const Vector3d& p) { return Vector3d(-10e-3 * std::pow(p.y() / most.y(), 3), 0, 0); }},
      {"EC0Y", [&](const Vector3d& p) { return Vector3d(-50e-6 * p.y(), 0, 0); }},
      {"EA0Z", [&](const Vector3d& p) { return Vector3d(0, 50e-6 * p.z(), 0); }}};
  for (const auto& [name, moved] : motions) {
    EXPECT_NEAR(found.at(name).shown.heights[1].lsc_mm, shown_lsc_mm(moved), kSampling_mm) << name;
    EXPECT_GT(shown_lsc_mm(moved), 0.2e-3) << name;
  }
  EXPECT_EQ(found.at("EAX X").amount, 50);
  EXPECT_EQ(found.at("EAX X").unit, Unit::urad);
  EXPECT_EQ(found.at("linear_backlash:X").unit, Unit::um);
  EXPECT_TRUE(found.at("linear_backlash:X").seen_in_roundness());
}

/// The tool stands along Z: what Z does wrong moves it along itself.
TEST(Sensitivities, OfMotionsAlongTheToolAreNone) {
  const auto found = by_name(usual_piece(15, 10));
  for (const char* name : {"EZZ Z", "EZX X^2", "EZX X^3", "EZY Y^2", "EZY Y^3", "linear_backlash:Z"})
    EXPECT_TRUE(found.at(name).seen_in.empty()) << name;
}

RotaryErrors of_c(double ex_um, double ey_um, double eb_urad = 0) {
  return {.turn = {.translation_mm = {ex_um * 1e-3, ey_um * 1e-3, 0}, .rotation_rad = {0, eb_urad * 1e-6, 0}}};
}

TEST(Sensitivities, OfAOffsetShowsItsUndulationsAsPublished) {
  const TestPiece piece = usual_piece(15, 10);
  const std::vector<Undulation> waves = undulations(
      radial_trace(shown_traces(piece, [](IndexedPosition) { return of_c(10, 0); })[0], piece.cone.half_angle), 4);
  EXPECT_NEAR(waves[2].amplitude_mm * 1e3, 2.0, kTwoDigits);
  EXPECT_NEAR(waves[3].amplitude_mm * 1e3, .97, 0.0055);
  EXPECT_NEAR(waves[4].amplitude_mm * 1e3, .53, 0.0055);
}

/// A tilt of A that grows by 20 urad in 30 deg, and EYA ~ sin A, which only lifts the table.
TEST(Sensitivities, OfTiltingAxisMotionsAreThePublishedOnes) {
  const auto eaa = [](IndexedPosition at) {
    return RotaryErrors{.tilt = {.rotation_rad = {20e-6 * at.a.in_degrees() / 30, 0, 0}}};
  };
  EXPECT_NEAR(shown(eaa).heights[1].lsc_mm * 1e3, .08, 0.0055);
  const auto eya = [](IndexedPosition at) {
    return RotaryErrors{.tilt = {.translation_mm = {0, 5e-3 * std::sin(at.a.in_radians()), 0}}};
  };
  EXPECT_LT(shown(eya).heights[1].lsc_mm, 1e-5);
}

TEST(Sensitivities, CounterRotatingShowsAndCoRotatingOnlyDisplaces) {
  const auto counter =
      shown([](IndexedPosition at) { return of_c(5 * std::cos(at.c.in_radians()), -5 * std::sin(at.c.in_radians())); });
  EXPECT_NEAR(counter.heights[0].lsc_mm * 1e3, 7.9, kTwoDigits);
  const auto co = [](IndexedPosition at) {
    return of_c(5 * std::cos(at.c.in_radians()), 5 * std::sin(at.c.in_radians()));
  };
  EXPECT_LT(shown(co).heights[0].lsc_mm, 1e-5);
  EXPECT_LT(shown(co).heights[0].center_mm.norm(), 1e-5);  // set up on the table as it stood: nothing at all
  EXPECT_NEAR(shown(co, false).heights[0].center_mm.norm() * 1e3, 4.9, kTwoDigits);
}

/// Published centres and tilts hold where the workpiece is placed by the nominal axes, not set up at A = C = 0;
/// roundness is the same either way. Published sizes are radii.
TEST(Sensitivities, CentresAndTiltsArePublishedForErrorsNotCountedFromTheReference) {
  const auto ex0c = [](IndexedPosition) { return of_c(10, 0); };
  EXPECT_NEAR(shown(ex0c, false).heights[0].center_mm.norm() * 1e3, 6.6, kTwoDigits);
  EXPECT_NEAR(shown(ex0c, false).heights[0].lsc_mm, shown(ex0c).heights[0].lsc_mm, 1e-5);
  const auto eb0a = [](IndexedPosition) { return RotaryErrors{.tilt = {.rotation_rad = {0, 50e-6, 0}}}; };
  EXPECT_NEAR(shown(eb0a, false).axis_tilt_rad->norm() * 1e6, 34, 0.5);
  const auto eb0c = [](IndexedPosition) { return of_c(0, 0, 50); };
  EXPECT_NEAR(shown(eb0c, false).axis_tilt_rad->norm() * 1e6, 33, 0.5);
  const auto ec0a = [](IndexedPosition) { return RotaryErrors{.tilt = {.rotation_rad = {0, 0, 50e-6}}}; };
  EXPECT_NEAR(shown(ec0a, false).heights[0].center_mm.norm() * 1e3, 2.1, kTwoDigits);
  const auto ey0a = [](IndexedPosition) { return RotaryErrors{.tilt = {.translation_mm = {0, 10e-3, 0}}}; };
  const double nominal = 80 - 4 * std::tan(15 * std::numbers::pi / 180);
  EXPECT_NEAR((shown(ey0a).heights[0].diameter_mm - nominal) / 2 * 1e3, -9, kTwoDigits);
  EXPECT_NEAR((shown([](IndexedPosition) { return of_c(0, 10); }).heights[0].diameter_mm - nominal) / 2 * 1e3, -8.6,
              kTwoDigits);
}

TEST(Sensitivities, ABetterPieceShowsMoreOfTheLeastVisibleError) {
  TestPiece piece = usual_piece(15, 10);
  piece.points = 72;
  const BetterPiece better =
      better_piece(piece, effect_context(trunnion_machine()), [](std::span<const ToolPosition>) { return true; });
  EXPECT_THAT(better.never, ElementsAre("EZ0A", "EC0A"));
  EXPECT_NEAR(better.least_seen_here_mm * 1e3, .88, 0.01);
  EXPECT_GT(better.least_seen_mm, 2 * better.least_seen_here_mm);
  const auto again = by_name(better.piece);
  for (const char* name : {"EY0A", "EB0A", "EX0C", "EY0C", "EA0C", "EB0C"})
    EXPECT_GE(std::max(again.at(name).shown.heights[0].lsc_mm, again.at(name).shown.heights[2].lsc_mm),
              better.least_seen_mm - 1e-9);
}

}  // namespace
}  // namespace trunnion
