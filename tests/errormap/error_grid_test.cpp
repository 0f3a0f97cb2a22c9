#include "errormap/error_grid.h"

#include <gtest/gtest.h>

#include "errormap/fields.h"
#include "support/noise.h"

namespace trunnion {
namespace {

const std::vector<Angle> kA = stations_deg({-90, -60, -30, 0});
const std::vector<Angle> kC = stations_deg({0, 60, 120, 180, 240, 300});

ErrorGrid drawn(std::uint64_t seed, const std::vector<Angle>& a, const std::vector<Angle>& c) {
  testing::Noise noise(seed);
  ErrorGrid grid = zero_grid(a, c);
  Eigen::VectorXd values(static_cast<Eigen::Index>(grid.coefficient_count()));
  for (Eigen::Index k = 0; k < values.size(); ++k) values[k] = 1e-3 * noise.normal();
  return with_coefficients(grid, values);
}

TEST(ErrorGrid, ItsCoefficientsStandWhereItsOffsetsSay) {
  const ErrorGrid grid = drawn(1, kA, kC);
  const Eigen::VectorXd v = grid.coefficients();
  ASSERT_EQ(v.size(), 6 * (4 + 24));
  EXPECT_EQ(PoseError::from_vector(v.segment<6>(static_cast<Eigen::Index>(grid.tilt_offset(2)))), grid.tilt[2]);
  EXPECT_EQ(PoseError::from_vector(v.segment<6>(static_cast<Eigen::Index>(grid.turn_offset(3, 1)))),
            grid.at_node(3, 1).turn);
  EXPECT_EQ(with_coefficients(zero_grid(kA, kC), v), grid);
}

TEST(ErrorGrid, SplittingAfterEq1MovesNoPoseAndLeavesMeansOfZero) {
  for (const auto& [name, both] : twins()) {
    const KinematicChain chain(both.machine);
    const ErrorGrid grid = drawn(2, kA, kC), split = split_after_eq1(grid, chain);
    if (!chain.tilt_carries_turn()) {
      EXPECT_EQ(split, grid) << name;
      continue;
    }
    for (std::size_t i = 0; i < kA.size(); ++i) {
      Vector6d mean = Vector6d::Zero();
      for (std::size_t j = 0; j < kC.size(); ++j) {
        mean += split.at_node(i, j).turn.vector() / 6;
        const RelativeErrorJacobian jac = relative_error_jacobian(chain, {kA[i], kC[j]}, {});
        const Eigen::Matrix<double, 12, 1> change = stacked(split.at_node(i, j)) - stacked(grid.at_node(i, j));
        EXPECT_LT((jac.here * change).norm(), 1e-15 * 1e3) << name;
      }
      EXPECT_LT(mean.norm(), 1e-17) << name;
    }
  }
}

/// Maps as Eq. (12) and (13) make them from pose errors relative to the reference pose.
ErrorGrid gauged(const RotaryErrors& constants) {
  const KinematicChain chain(twin("w C' A' Y' b X Z t").machine);
  ErrorGrid grid = zero_grid(kA, kC);
  for (std::size_t i = 0; i < kA.size(); ++i)
    for (std::size_t j = 0; j < kC.size(); ++j) {
      const RelativeErrorJacobian jac = relative_error_jacobian(chain, {kA[i], kC[j]}, {});
      const Vector6d delta = (jac.here + jac.reference) * stacked(constants);
      grid.turn[i * kC.size() + j] = PoseError::from_vector(jac.here.rightCols<6>().inverse() * delta);
    }
  return split_after_eq1(grid, chain);
}

Vector6d shown(const PoseError& e) { return (Vector6d() << 1e3 * e.translation_mm, 1e6 * e.rotation_rad).finished(); }

Vector6d six(double x, double y, double z, double a, double b, double c) {
  return (Vector6d() << x, y, z, a, b, c).finished();
}

constexpr double kPrinted = .005000001;  // half a unit of the second decimal

TEST(ErrorGrid, ConstantErrorsOfCSeenThroughTheGauge) {
  const ErrorGrid grid = gauged({{}, um_urad(20, 10, 0, 30, -20, 0)});
  const std::vector<Vector6d> tilt = {six(20, 0, -10, 30, 0, 20), six(20, 5, -8.66, 30, -10, 17.32),
                                      six(20, 8.66, -5, 30, -17.32, 10), six(20, 10, 0, 30, -20, 0)};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LT((shown(grid.tilt[i]) - tilt[i]).cwiseAbs().maxCoeff(), kPrinted) << i;
    const auto at = [&](std::size_t j) { return shown(grid.at_node(i, j).turn); };
    EXPECT_LT((at(0) - six(-20, -10, 0, -30, 20, 0)).cwiseAbs().maxCoeff(), kPrinted);
    EXPECT_LT((at(1) - six(-1.34, -22.32, 0, -32.32, -15.98, 0)).cwiseAbs().maxCoeff(), kPrinted);
    EXPECT_LT((at(3) - six(20, 10, 0, 30, -20, 0)).cwiseAbs().maxCoeff(), kPrinted);
  }
}

TEST(ErrorGrid, ConstantErrorsOfASeenThroughTheGauge) {
  const ErrorGrid grid = gauged({um_urad(0, 20, 10, 0, -20, 10), {}});
  const std::vector<Vector6d> tilt = {six(0, 10, 10, 0, -30, 10), six(0, 11.34, 5, 0, -28.66, 5),
                                      six(0, 15, 1.34, 0, -25, 1.34), six(0, 20, 0, 0, -20, 0)};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((shown(grid.tilt[i]) - tilt[i]).cwiseAbs().maxCoeff(), kPrinted) << i;
}

}  // namespace
}  // namespace trunnion
