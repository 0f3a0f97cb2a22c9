#include "testpiece/tool_path.h"

#include <gtest/gtest.h>

#include <cmath>

#include "error.h"
#include "testpiece/pieces.h"
#include "units/angle.h"

namespace trunnion {
namespace {

constexpr double kPrinted_mm = 0.6e-5;  // published positions carry five decimals
constexpr double kPrinted_deg = 0.6e-5;

const ToolPosition& at_phi(const std::vector<ToolPosition>& path, double phi_deg) {
  for (const ToolPosition& p : path)
    if (std::abs(p.phi_rad - phi_deg * kTurn_rad / 360) < 1e-9) return p;
  throw std::logic_error("no position at that phi");
}

/// Half angle 15, tilt 10 deg, base 80 mm standing 50 mm off the C axis in X, 50 mm high; tool 20 mm, 5 mm below.
TEST(FlankMillingPath, StandsWhereTheWorkedExampleSays) {
  const KinematicChain chain(trunnion_machine());
  TestPiece piece = usual_piece(15, 10);
  piece.tool.overhang = Length::millimetres(5);
  const std::vector<ToolPosition> path = flank_milling_path(piece, chain);
  struct Row {
    double phi_deg, a_deg, c_deg;
    Eigen::Vector3d tip_w, tip_r;
  };
  const Row rows[] = {
      {0, -5, -270, {99.79004, 0, 38.94466}, {0, 102.80456, 30.09919}},
      {90, -17.96386, -392.94581, {49.61078, 50.95335, 47.79261}, {69.34339, 29.74956, 40.59636}},
      {180, -25, -450, {-.56848, 0, 56.64057}, {0, 24.45256, 51.09354}},
  };
  for (const Row& row : rows) {
    const ToolPosition& p = at_phi(path, row.phi_deg);
    EXPECT_NEAR(p.at.a.in_degrees(), row.a_deg, kPrinted_deg);
    EXPECT_NEAR(p.at.c.in_degrees(), row.c_deg, kPrinted_deg);
    EXPECT_LT((p.nominal.tip_w_mm - row.tip_w).cwiseAbs().maxCoeff(), kPrinted_mm) << p.nominal.tip_w_mm.transpose();
    EXPECT_LT((p.tip_r_mm - row.tip_r).cwiseAbs().maxCoeff(), kPrinted_mm) << p.tip_r_mm.transpose();
  }
  EXPECT_LT((at_phi(path, 0).nominal.axis_w - Eigen::Vector3d(-.087156, 0, .996195)).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_LT((at_phi(path, 90).nominal.axis_w - Eigen::Vector3d(.167731, -.258819, .951251)).cwiseAbs().maxCoeff(),
            1e-6);
}

/// Largest and smallest C and A over the path, and the largest step of C, deg.
struct Extent {
  double c_low = 1e9, c_high = -1e9, a_low = 1e9, a_high = -1e9, c_step = 0, c_first = 0, c_last = 0;
};
Extent extent(const std::vector<ToolPosition>& path) {
  Extent e{.c_first = path.front().at.c.in_degrees(), .c_last = path.back().at.c.in_degrees()};
  for (std::size_t i = 0; i < path.size(); ++i) {
    const double c = path[i].at.c.in_degrees(), a = path[i].at.a.in_degrees();
    e.c_low = std::min(e.c_low, c), e.c_high = std::max(e.c_high, c);
    e.a_low = std::min(e.a_low, a), e.a_high = std::max(e.a_high, a);
    if (i > 0) e.c_step = std::max(e.c_step, std::abs(c - path[i - 1].at.c.in_degrees()));
  }
  return e;
}

TEST(FlankMillingPath, TurnsCFullyWhereTheTiltIsBelowTheHalfAngle) {
  const KinematicChain chain(trunnion_machine());
  for (const double tilt : {0.0, 10.0, 14.0, 14.999}) {
    const Extent e = extent(flank_milling_path(usual_piece(15, tilt), chain));
    EXPECT_NEAR(e.c_last - e.c_first, -360, 1e-7) << tilt;
    EXPECT_NEAR(e.a_low, -15 - tilt, 1e-6);
    EXPECT_NEAR(e.a_high, tilt - 15, 1e-6);
    EXPECT_LE(e.c_step, 0.5 + 1e-9);
  }
}

TEST(FlankMillingPath, SwingsCBackAndForthWhereTheTiltIsAboveTheHalfAngle) {
  const Extent e = extent(flank_milling_path(usual_piece(15, 30), KinematicChain(trunnion_machine())));
  EXPECT_NEAR(e.c_last, e.c_first, 1e-9);
  // The rulings lie within asin(sin 15 / sin 30) of the axis, seen along Z.
  EXPECT_NEAR(e.c_high - e.c_low, 2 * std::asin(std::sin(kTurn_rad / 24) / std::sin(kTurn_rad / 12)) * 360 / kTurn_rad,
              0.01);
  EXPECT_NEAR(e.a_high, -15, 1e-9);
  EXPECT_NEAR(e.a_low, -45, 1e-9);
}

TEST(FlankMillingPath, PassesUprightWithCSwingingOnAndTheTipAtRest) {
  const KinematicChain chain(trunnion_machine());
  TestPiece piece = usual_piece(15, 15);
  piece.cone.tilt_azimuth = Angle::degrees(90);  // upright in the midst of the path
  const std::vector<ToolPosition> path = flank_milling_path(piece, chain);
  const Extent e = extent(path);
  EXPECT_NEAR(e.a_high, 0, 1e-9);
  EXPECT_LE(e.c_step, 0.5 + 1e-9);
  EXPECT_NEAR(e.c_last - e.c_first, -360, 1e-6);
  int swinging = 0;
  for (std::size_t i = 1; i < path.size(); ++i)
    if (path[i].at.a.in_degrees() > -1e-6 && (path[i].at.c - path[i - 1].at.c).in_degrees() < -0.1) ++swinging;
  EXPECT_GE(swinging, 300);  // half a turn by no more than half a degree
}

TEST(FlankMillingPath, StartsUprightWithoutAJump) {
  const Extent e = extent(flank_milling_path(usual_piece(15, 15), KinematicChain(trunnion_machine())));
  EXPECT_LE(e.c_step, 0.5 + 1e-9);
  EXPECT_NEAR(std::abs(e.c_last - e.c_first), 180, 0.05);  // upright again, C stays where the last step left it
}

TEST(FlankMillingPath, ComesBackToTheSameToolInEveryPlaceAndSense) {
  const KinematicChain chain(trunnion_machine());
  for (const int sense : {1, -1}) {
    TestPiece piece = usual_piece(15, 10);
    piece.sense = sense;
    piece.cone.tilt_azimuth = Angle::degrees(-140);
    piece.cone.base_center_w_mm = {-30, 12, 44};
    const std::vector<ToolPosition> path = flank_milling_path(piece, chain);
    const Eigen::Isometry3d frame = w_from_cone(piece.cone);
    for (const ToolPosition& p : path) {
      // The tool's side touches the cone along the whole ruling.
      for (const double h : {0.0, 7.0, 20.0}) {
        const ConePoint on = cone_point(piece.cone, frame, Angle::radians(p.phi_rad), Length::millimetres(h));
        const Eigen::Vector3d off = on.point_w_mm - p.nominal.tip_w_mm;
        EXPECT_NEAR((off - off.dot(p.nominal.axis_w) * p.nominal.axis_w).norm(), 10, 1e-12);
      }
      const Eigen::Isometry3d r_from_w = chain.r_from_w(p.at);
      EXPECT_LT((r_from_w.linear() * p.nominal.axis_w - Eigen::Vector3d::UnitZ()).norm(), 1e-11);
      EXPECT_LE(p.at.a.in_degrees(), 0);
    }
    EXPECT_NEAR(path.back().phi_rad, sense * kTurn_rad, 1e-12);
    EXPECT_LT((path.back().nominal.tip_w_mm - path.front().nominal.tip_w_mm).norm(), 1e-12);
    EXPECT_EQ(path[1].turn_sense, -sense);  // the table turns against the cut
  }
}

TEST(FlankMillingPath, TellsSensesOfMotionAndTime) {
  TestPiece piece = usual_piece(15, 30);
  piece.feed_mm_per_min = 600;
  const std::vector<ToolPosition> path = flank_milling_path(piece, KinematicChain(trunnion_machine()));
  // A falls until phi = 180 deg (steepest) and rises after it; C comes and goes.
  EXPECT_EQ(at_phi(path, 0).tilt_sense, -1);
  EXPECT_EQ(at_phi(path, 90).tilt_sense, -1);
  EXPECT_EQ(at_phi(path, 270).tilt_sense, 1);
  EXPECT_NE(at_phi(path, 10).turn_sense, at_phi(path, 180).turn_sense);
  double way = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    way += (path[i].nominal.tip_w_mm - path[i - 1].nominal.tip_w_mm).norm();
    EXPECT_GE(path[i].time_s, path[i - 1].time_s);
  }
  EXPECT_NEAR(path.back().time_s, way / 10, 1e-9);
}

TEST(FlankMillingPath, RoundedWordsAreNoReversals) {
  const KinematicChain chain(trunnion_machine());
  std::vector<ToolPosition> path;
  for (int i = 0; i < 40; ++i) {
    const double to_and_fro = i < 20 ? i : 40 - i;  // Y turns about in the middle; X stands, its words tremble
    path.push_back({.tip_r_mm = {i % 2 == 0 ? 5.0 : 5.0005, 0.1 * to_and_fro, 0}});
  }
  set_senses(path, chain, Length(), Length::micrometres(2));
  for (const ToolPosition& p : path) EXPECT_EQ(p.linear_sense.x(), 0);
  EXPECT_EQ(path[20].linear_sense.y(), 1);
  EXPECT_EQ(path[21].linear_sense.y(), -1);
  set_senses(path, chain, Length());
  EXPECT_EQ(path[10].linear_sense.x() * path[11].linear_sense.x(), -1);
}

TEST(FlankMillingPath, ServesEveryMachineThatCanReachIt) {
  for (const char* code : {"w C' A' Y' b X Z t", "w C' B' Y' b X Z t", "w C' X' b Y Z A t", "w b X Y Z C B t"}) {
    const KinematicChain chain(trunnion_machine(code));
    for (const ToolPosition& p : flank_milling_path(usual_piece(15, 10), chain, {.steps_per_turn = 360})) {
      const Eigen::Vector3d along =
          chain.r_from_w(p.at).linear().transpose() * (chain.r_from_t(p.at).linear() * Eigen::Vector3d::UnitZ());
      EXPECT_LT((along - p.nominal.axis_w).norm(), 1e-11) << code;
    }
  }
  const KinematicChain odd(trunnion_machine("w A' C' Y' b X Z t"));
  EXPECT_THROW(flank_milling_path(usual_piece(15, 10), odd), ModelError);
}

TEST(ConeFrustum, PhiRunsFromThePartOfXSquareToTheAxis) {
  ConeFrustum cone = usual_piece(15, 90).cone;
  EXPECT_THROW(w_from_cone(cone), ModelError);  // the axis lies along X
  cone.tilt = Angle::degrees(30);
  cone.tilt_azimuth = Angle::degrees(37);
  const Eigen::Isometry3d frame = w_from_cone(cone);
  EXPECT_NEAR(frame.linear().determinant(), 1, 1e-15);
  const Eigen::Vector3d axis = frame.linear().col(2);
  EXPECT_NEAR(axis.z(), std::cos(kTurn_rad / 12), 1e-15);
  EXPECT_NEAR(std::atan2(axis.y(), axis.x()), 37 * kTurn_rad / 360, 1e-15);
  EXPECT_NEAR(frame.linear().col(0).cross(Eigen::Vector3d(1, 0, 0) - axis.x() * axis).norm(), 0, 1e-15);
  EXPECT_GT(frame.linear()(0, 0), 0);
  EXPECT_NEAR(frame.linear()(0, 1), 0, 1e-15);  // square to X
}

}  // namespace
}  // namespace trunnion
