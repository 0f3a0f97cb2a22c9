#include "testpiece/cone_evaluation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "error.h"
#include "testpiece/flank_fit.h"
#include "units/angle.h"

namespace trunnion {
namespace {

const Angle kHalfAngle = Angle::degrees(15);

/// Traces of a cone of 80 mm base whose deviation is `normal_mm(phi, h)`.
std::vector<ConeTrace> traces(const std::vector<double>& heights, auto normal_mm) {
  std::vector<ConeTrace> list;
  for (const double h : heights) {
    ConeTrace trace{.h_mm = h, .nominal_radius_mm = 40 - h * std::tan(kHalfAngle.in_radians())};
    for (int i = 0; i < 360; ++i) {
      trace.phi_rad.push_back(kTurn_rad * i / 360);
      trace.normal_mm.push_back(normal_mm(trace.phi_rad.back(), h));
    }
    list.push_back(trace);
  }
  return list;
}

TEST(ConeEvaluation, ANominalConeHasItsNominalSizeAngleAndAxis) {
  const ConeEvaluation found = evaluate_cone(traces({2, 10, 18}, [](double, double) { return 0.0; }), kHalfAngle);
  EXPECT_NEAR(found.half_angle->in_degrees(), 15, 1e-12);
  EXPECT_NEAR(found.axis_tilt_rad->norm(), 0, 1e-15);
  EXPECT_NEAR(found.heights[0].diameter_mm, 80 - 4 * std::tan(kHalfAngle.in_radians()), 1e-12);
  EXPECT_EQ(found.rms_mm, 0);
  EXPECT_NEAR(*found.conicity_mm, 0, 1e-12);
}

TEST(ConeEvaluation, ATiltedAndDisplacedConeShowsTiltAndCentresAndStaysRound) {
  // Moved by c + t h square to the axis: the normal moves by cos(half angle) times the part along phi.
  const double cosine = std::cos(kHalfAngle.in_radians());
  const ConeEvaluation found =
      evaluate_cone(traces({2, 10, 18},
                           [&](double phi, double h) {
                             return cosine * ((5e-3 + 40e-6 * h) * std::cos(phi) + (-3e-3 + 20e-6 * h) * std::sin(phi));
                           }),
                    kHalfAngle);
  EXPECT_NEAR(found.axis_tilt_rad->x(), 40e-6, 1e-9);
  EXPECT_NEAR(found.axis_tilt_rad->y(), 20e-6, 1e-9);
  EXPECT_NEAR(found.heights[1].center_mm.x(), 5.4e-3, 1e-8);
  EXPECT_NEAR(found.heights[1].center_mm.y(), -2.8e-3, 1e-8);
  EXPECT_NEAR(*found.concentricity_mm, 16 * std::hypot(40e-6, 20e-6), 1e-8);
  // The trace of a circle seen off its centre is a limacon: (6 um)^2 / 2 R remains.
  for (const HeightEvaluation& at : found.heights) EXPECT_LT(at.mzc_mm, 1.5e-6);
}

TEST(ConeEvaluation, ASteeperConeShowsItsHalfAngleAndConicity) {
  const double more = 100e-6, tangent = std::tan(kHalfAngle.in_radians() + more);
  const double nominal = std::tan(kHalfAngle.in_radians()), cosine = std::cos(kHalfAngle.in_radians());
  const ConeEvaluation found =
      evaluate_cone(traces({0, 20}, [&](double, double h) { return cosine * h * (nominal - tangent); }), kHalfAngle);
  EXPECT_NEAR((*found.half_angle - kHalfAngle).in_radians(), more, 1e-12);
  EXPECT_NEAR(*found.conicity_mm, 2 * 20 * (tangent - nominal), 1e-12);
}

TEST(ConeEvaluation, OneHeightHasNeitherAngleNorAxis) {
  const ConeEvaluation found = evaluate_cone(traces({10}, [](double, double) { return 1e-3; }), kHalfAngle);
  EXPECT_FALSE(found.half_angle || found.axis_tilt_rad || found.concentricity_mm || found.conicity_mm);
  EXPECT_NEAR(found.heights[0].lsc_mm, 0, 1e-12);
  EXPECT_NEAR(found.rms_mm, 1e-3, 1e-15);
}

TEST(ConeEvaluation, TheFilterTakesShortWavesOffBeforeTheCirclesAreFitted) {
  const auto short_waves = traces({2, 18}, [](double phi, double) { return 1e-3 * std::cos(60 * phi); });
  const double unfiltered = evaluate_cone(short_waves, kHalfAngle).heights[0].lsc_mm;
  EXPECT_NEAR(unfiltered, 2e-3 / std::cos(kHalfAngle.in_radians()), 1e-7);
  EXPECT_NEAR(evaluate_cone(short_waves, kHalfAngle, {.filter_upr = 60}).heights[0].lsc_mm, unfiltered / 2, 1e-7);
  EXPECT_LT(evaluate_cone(short_waves, kHalfAngle, {.filter_upr = 15}).heights[0].lsc_mm, 1e-7);
  // What is drawn is what is judged.
  EXPECT_EQ(least_squares_circle(radial_trace(short_waves[0], kHalfAngle, {.filter_upr = 60})).roundness_mm,
            evaluate_cone(short_waves, kHalfAngle, {.filter_upr = 60}).heights[0].lsc_mm);
}

/// The normal deviation of a cone that was really displaced: turned and shifted points, seen along the nominal normal.
std::vector<ConeTrace> displaced(const Eigen::Vector3d& shift, const Eigen::Vector3d& turn, double grown) {
  const double sine = std::sin(kHalfAngle.in_radians()), cosine = std::cos(kHalfAngle.in_radians());
  return traces({2, 10, 18}, [&](double phi, double h) {
    const double r = 40 - h * sine / cosine;
    const Eigen::Vector3d p(r * std::cos(phi), r * std::sin(phi), h);
    const Eigen::Vector3d normal(cosine * std::cos(phi), cosine * std::sin(phi), sine);
    return normal.dot(shift + turn.cross(p)) + grown;
  });
}

TEST(FlankFit, TakesARigidDisplacementAndSizeOutAndLeavesTheRest) {
  const FlankFit fit = fit_flank(displaced({3e-3, -2e-3, 0}, {30e-6, -20e-6, 70e-6}, 4e-3), kHalfAngle);
  EXPECT_NEAR(fit.shift_mm.x(), 3e-3, 1e-12);
  EXPECT_NEAR(fit.shift_mm.y(), -2e-3, 1e-12);
  EXPECT_NEAR(fit.tilt_rad.x(), 30e-6, 1e-12);
  EXPECT_NEAR(fit.tilt_rad.y(), -20e-6, 1e-12);
  EXPECT_NEAR(fit.size_mm, 4e-3, 1e-12);
  EXPECT_NEAR(fit.form_mm, 0, 1e-12);
  // Along its axis a cone moves as it grows.
  const FlankFit raised = fit_flank(displaced({0, 0, 5e-3}, Eigen::Vector3d::Zero(), 0), kHalfAngle);
  EXPECT_NEAR(raised.size_mm, 5e-3 * std::sin(kHalfAngle.in_radians()), 1e-12);
}

TEST(FlankFit, ThreeLobesAndAWrongAngleRemain) {
  const auto lobes = traces({2, 18}, [](double phi, double) { return 2e-3 * std::cos(3 * phi); });
  EXPECT_NEAR(fit_flank(lobes, kHalfAngle).form_mm, 4e-3, 1e-9);
  EXPECT_NEAR(fit_flank(lobes, kHalfAngle).rms_mm, std::sqrt(2) * 1e-3, 1e-9);
  const auto steeper = traces({0, 20}, [](double, double h) { return 1e-4 * h; });
  EXPECT_NEAR(fit_flank(steeper, kHalfAngle).form_mm, 2e-3, 1e-9);
}

TEST(FlankFit, OneHeightIsFittedByTranslations) {
  const auto one = traces({10}, [](double phi, double) { return 2e-3 * std::cos(phi) + 1e-3; });
  const FlankFit fit = fit_flank(one, kHalfAngle);
  EXPECT_NEAR(fit.form_mm, 0, 1e-9);
  EXPECT_NEAR(fit.size_mm, 1e-3, 1e-9);
}

TEST(ConeEvaluation, RefusesAPieceWithoutTraces) { EXPECT_THROW(evaluate_cone({}, kHalfAngle), InputError); }

}  // namespace
}  // namespace trunnion
