#include "errormap/baked_map.h"

#include <gtest/gtest.h>

#include "error.h"
#include "errormap/fields.h"
#include "support/noise.h"

namespace trunnion {
namespace {

using Eigen::Vector3d;

const std::vector<Angle> kBakedA = stations_deg({-90, -60, -30, 0});
const std::vector<Angle> kBakedC = stations_deg({0, 60, 120, 180, 240, 300});
const Range<Angle> kRange{Angle::degrees(-90), Angle::degrees(0)};

/// The table's pose error of a trunnion whose map is drawn at random: 5 um, 30 urad.
struct Table {
  KinematicChain chain{twin("w C' A' Y' b X Z t").machine};
  std::shared_ptr<const ErrorSurface> surface;
  PoseError operator()(IndexedPosition at) const {
    return relative_pose_error(chain, at, surface->at(at), surface->at({}), {});
  }
};

Table table(Interpolation method = Interpolation::trig_cubic) {
  testing::Noise noise(1);
  ErrorGrid grid = zero_grid(kBakedA, kBakedC);
  Eigen::VectorXd values(static_cast<Eigen::Index>(grid.coefficient_count()));
  for (Eigen::Index k = 0; k < values.size(); ++k) values[k] = (k % 6 < 3 ? 5e-3 : 3e-5) * noise.normal();
  return {.surface = make_surface(method, with_coefficients(grid, values))};
}

TEST(BakedMap, StaysWithinTheErrorItStates) {
  const Table original = table();
  for (const double um : {0.1, 0.001}) {
    const BakeTolerance tolerance{.displacement = Length::micrometres(um), .rotation = Angle::microradians(5 * um)};
    const BakedMap baked(original, kRange, tolerance);
    EXPECT_TRUE(baked.meets(tolerance)) << baked.error().displacement.in_micrometres();
    testing::Noise noise(2);
    for (int k = 0; k < 20000; ++k) {
      const IndexedPosition at = degrees(noise.uniform(-90, 0), noise.uniform(-720, 720));
      const PoseError difference = baked.at(at) - original(at);
      const double turn = difference.rotation_rad.norm();
      // Between the points where it was measured the difference may be a little larger.
      ASSERT_LT(difference.translation_mm.norm() + 200 * turn, 1.2 * baked.error().displacement.in_millimetres());
      ASSERT_LT(turn, 1.2 * baked.error().rotation.in_radians());
    }
  }
}

TEST(BakedMap, SaysSoWhereTheToleranceIsOutOfReach) {
  // Piecewise linear: no smooth piece follows a kink, however small.
  const BakeTolerance tolerance{.displacement = Length::micrometres(1e-9), .rotation = Angle::microradians(1e-9)};
  const BakedMap baked(table(Interpolation::bilinear), kRange, tolerance);
  EXPECT_FALSE(baked.meets(tolerance));
  EXPECT_LE(baked.a_nodes() * baked.c_nodes(), BakedMap::kMaxNodes);
  EXPECT_GT(baked.error().displacement.in_micrometres(), 1e-6);
  EXPECT_LT(baked.error().displacement.in_micrometres(), 1);
}

TEST(BakedMap, MeetsItsOriginalAtTheNodesAndTheEnds) {
  const Table original = table();
  const BakedMap baked(original, kRange);
  for (const double a : {-90., 0.})
    for (std::size_t j = 0; j < baked.c_nodes(); ++j) {
      const IndexedPosition at = degrees(a, 360. * static_cast<double>(j) / static_cast<double>(baked.c_nodes()));
      EXPECT_LT((baked.at(at) - original(at)).vector().norm(), 1e-15);
    }
}

TEST(BakedMap, IsContinuousInValueAndSlopeOverTheSeamAndEveryCell) {
  const BakedMap baked(table(), kRange, {.displacement = Length::micrometres(0.1)});
  const double c_cell = 360. / static_cast<double>(baked.c_nodes());
  const double a_cell = 90. / static_cast<double>(baked.a_nodes() - 1);
  constexpr double kStep_deg = 1e-9;
  const auto jump = [&](double a, double c, double da, double dc) {
    const PoseErrorSlopes left = baked.with_slopes(degrees(a - da, c - dc)),
                          right = baked.with_slopes(degrees(a + da, c + dc));
    return (left.error - right.error).vector().norm() + (left.by_a - right.by_a).vector().norm() +
           (left.by_c - right.by_c).vector().norm();
  };
  for (double a = -88; a < 0; a += 9.7) {
    EXPECT_LT(jump(a, 0, 0, kStep_deg), 1e-10);
    EXPECT_LT(jump(a, 360, 0, kStep_deg), 1e-10);
    EXPECT_LT(jump(a, 3 * c_cell, 0, kStep_deg), 1e-10);
  }
  for (double c = 0; c < 360; c += 31) EXPECT_LT(jump(-90 + 2 * a_cell, c, kStep_deg, 0), 1e-10);
}

TEST(BakedMap, ItsSlopesAreThoseOfItsValues) {
  const BakedMap baked(table(), kRange);
  testing::Noise noise(3);
  constexpr double kStep = 1e-5;
  for (int k = 0; k < 200; ++k) {
    const double a = noise.uniform(-1.5, -.01), c = noise.uniform(-10, 10);
    const auto value = [&](double da, double dc) {
      return baked.at({Angle::radians(a + da), Angle::radians(c + dc)}).vector();
    };
    const PoseErrorSlopes found = baked.with_slopes({Angle::radians(a), Angle::radians(c)});
    EXPECT_LT((found.error.vector() - value(0, 0)).norm(), 1e-16);
    EXPECT_LT((found.by_a.vector() - (value(kStep, 0) - value(-kStep, 0)) / (2 * kStep)).norm(), 1e-7);
    EXPECT_LT((found.by_c.vector() - (value(0, kStep) - value(0, -kStep)) / (2 * kStep)).norm(), 1e-7);
  }
}

TEST(BakedMap, GivesTheDeviationsOfItsPoseErrors) {
  for (const double size : {1., 30.}) {  // up to 5 mrad
    const Table original = table();
    const BakedMap baked([&](IndexedPosition at) { return size * original(at); }, kRange);
    testing::Noise noise(4);
    std::vector<double> a, c;
    std::vector<Vector3d> p, d(1000);
    for (std::size_t k = 0; k < d.size(); ++k) {
      a.push_back(noise.uniform(-1.57, 0)), c.push_back(noise.uniform(-20, 20));
      p.push_back(300 * Vector3d(noise.uniform(-1, 1), noise.uniform(-1, 1), noise.uniform(-1, 1)));
    }
    baked.deviations_mm(a, c, p, d);
    for (std::size_t k = 0; k < d.size(); ++k) {
      const PoseError e = baked.at({Angle::radians(a[k]), Angle::radians(c[k])});
      // The cubic term that is left out: p w^3 / 6.
      const double left_out = 500 * std::pow(e.rotation_rad.norm(), 3) / 2;
      EXPECT_LT((d[k] - displacement_mm(e, p[k])).norm(), 1e-14 + left_out);
    }
  }
}

TEST(BakedMap, RefusesWhatItDoesNotHold) {
  const BakedMap baked(table(), kRange);
  EXPECT_NO_THROW(baked.at(degrees(1e-10, 0)));
  EXPECT_THROW(baked.at(degrees(0.001, 0)), RangeError);
  EXPECT_THROW(baked.at(degrees(-90.001, 0)), RangeError);
  EXPECT_THROW(baked.at(degrees(std::nan(""), 0)), RangeError);
  EXPECT_THROW(baked.at(degrees(0, std::nan(""))), RangeError);
  EXPECT_THROW(baked.at(degrees(0, INFINITY)), RangeError);
  const std::vector<double> a = {0, .1}, c = {0, 0};
  const std::vector<Vector3d> p(2, Vector3d::Zero());
  std::vector<Vector3d> d(2);
  EXPECT_THROW(baked.deviations_mm(a, c, p, d), RangeError);
}

TEST(BakedMap, TakesASingleTilt) {
  const Table original = table();
  const BakedMap baked(original, {Angle(), Angle()});
  for (double c = 0; c < 720; c += 17)
    EXPECT_LT((baked.at(degrees(0, c)) - original(degrees(0, c))).vector().norm(),
              1.2 * baked.error().displacement.in_millimetres());
  EXPECT_THROW(baked.at(degrees(1, 0)), RangeError);
}

}  // namespace
}  // namespace trunnion
