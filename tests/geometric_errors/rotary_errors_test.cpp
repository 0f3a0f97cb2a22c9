#include "geometric_errors/rotary_errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "linear_algebra/factors.h"
#include "support/noise.h"
#include "support/probing_plan.h"
#include "support/replica.h"
#include "support/twin.h"

namespace trunnion {
namespace {

using Eigen::Vector3d;

const RotaryErrors kExample{um_urad(10, -20, 30, 40, -50, 60), um_urad(-5, 15, -25, -30, 20, 10)};
const IndexedPosition kExamplePosition = degrees(-30, 60);
constexpr double kPrinted = 6e-11;  // half a unit of the tenth decimal

RotaryErrors field(IndexedPosition at, double size) {
  const double a = at.a.in_radians(), c = at.c.in_radians();
  const RotaryErrors e{um_urad(5 + 4 * a, -6 + 3 * a * a, 7 - a, 30 * a + 11, -20, 15 + 9 * a),
                       um_urad(3 * std::sin(c) + a, 4 + std::cos(2 * c), -5, 12, 25 * std::cos(c) - 7, 14 * a * c)};
  return {size * e.tilt, size * e.turn};
}

TEST(RotaryErrors, ThePublishedExampleExactly) {
  const KinematicChain chain(twin("w C' A' Y' b X Z t").machine);
  const Vector3d w(90, -70, 110);
  const Eigen::Isometry3d actual = actual_r_from_w(chain, kExamplePosition, kExample);
  EXPECT_LT((actual * w - Vector3d(105.6193291242, 92.1750597379, 73.7963457864)).cwiseAbs().maxCoeff(), kPrinted);
  EXPECT_LT((chain.r_from_w(kExamplePosition) * w - Vector3d(105.6217782649, 92.1891108675, 73.7916512460))
                .cwiseAbs()
                .maxCoeff(),
            kPrinted);
  Eigen::Matrix<double, 3, 4> rows;
  rows << .4999679912, -.8660438816, -.0000533021, .0050014281,  //
      .7500336575, .4329644011, .4999913399, -.0195087529,       //
      -.4329913629, -.2500196442, .8660304020, .0008491346;
  EXPECT_LT((actual.matrix().topRows<3>() - rows).cwiseAbs().maxCoeff(), kPrinted);
}

Vector6d in_um_urad(const Vector6d& e) { return (Vector6d() << 1e3 * e.head<3>(), 1e6 * e.tail<3>()).finished(); }

TEST(RotaryErrors, ThePublishedExampleToFirstOrder) {
  const KinematicChain chain(twin("w C' A' Y' b X Z t").machine);
  const RelativeErrorJacobian j = relative_error_jacobian(chain, kExamplePosition, {});
  Vector6d absolute, gauged;
  absolute << 5, -19.5096189432, .8493649054, 10, -27.6794919243, 58.6602540378;
  gauged << -1.8301270189, -23.5945554338, -2.5656986041, -20.9807621135, -57.1891108675, -5.1313972081;
  EXPECT_LT((in_um_urad(j.here * stacked(kExample)) - absolute).cwiseAbs().maxCoeff(), kPrinted);
  EXPECT_LT((in_um_urad((j.here + j.reference) * stacked(kExample)) - gauged).cwiseAbs().maxCoeff(), kPrinted);
}

TEST(RotaryErrors, ThePublishedExampleRelativeToTheReferencePoseExactly) {
  const KinematicChain chain(twin("w C' A' Y' b X Z t").machine);
  Vector6d wanted;
  wanted << -1.82809, -23.59447, -2.56621, -20.98193, -57.18830, -5.13429;
  const PoseError found = relative_pose_error(chain, kExamplePosition, kExample, kExample, {});
  EXPECT_LT((in_um_urad(found.vector()) - wanted).cwiseAbs().maxCoeff(), 6e-6);
}

TEST(RotaryErrors, Eq11) {
  const KinematicChain chain(twin("w C' A' Y' b X Z t").machine);
  testing::Noise noise(8);
  for (int k = 0; k < 20; ++k) {
    const double a = noise.uniform(-2, 2);
    const IndexedPosition at{Angle::radians(a), Angle::radians(noise.uniform(0, 6))};
    Eigen::Matrix<double, 6, 12> wanted = Eigen::Matrix<double, 6, 12>::Zero();
    wanted.leftCols<6>().setIdentity();
    for (const Eigen::Index r : {0, 3}) {
      wanted(r, 6 + r) = 1;
      wanted(r + 1, 7 + r) = wanted(r + 2, 8 + r) = std::cos(a);
      wanted(r + 1, 8 + r) = -std::sin(a);
      wanted(r + 2, 7 + r) = std::sin(a);
    }
    EXPECT_LT((relative_error_jacobian(chain, at, {}).here - wanted).norm(), 1e-14);
  }
}

TEST(RotaryErrors, TheTableStandsWhereTheExactProductPutsIt) {
  testing::Noise noise(9);
  for (auto& [name, both] : twins()) {
    give_errors(both, [](IndexedPosition at) { return field(at, 20); });
    const KinematicChain chain(both.machine);
    for (int k = 0; k < 100; ++k) {
      const IndexedPosition at = degrees(noise.uniform(-110, 110), noise.uniform(0, 360));
      const Eigen::Isometry3d found = actual_r_from_w(chain, at, field(at, 20));
      const Vector3d p = 200 * Vector3d(noise.normal(), noise.normal(), noise.normal());
      const Vector3d wanted = both.exact.r_from_w(exact_state(both.machine, at, Vector3d::Zero())) * p;
      EXPECT_LT((found * p - wanted).norm(), 1e-12) << name;
    }
  }
}

TEST(RotaryErrors, TheTablesPoseErrorIsExactAndVanishesAtTheReferencePose) {
  testing::Noise noise(10);
  for (auto& [name, both] : twins()) {
    if (!both.exact.tool_axes.empty()) continue;
    give_errors(both, [](IndexedPosition at) { return field(at, 20); });
    const KinematicChain chain(both.machine);
    for (int k = 0; k < 100; ++k) {
      const IndexedPosition at = degrees(noise.uniform(-110, 110), noise.uniform(0, 360));
      const PoseError found = relative_pose_error(chain, at, field(at, 20), field({}, 20), {});
      const testing::AxisErrors wanted = both.exact.pose_error(exact_position(both.machine, at));
      EXPECT_LT((found.translation_mm - wanted.translation_mm).norm(), 1e-12) << name;
      EXPECT_LT((found.rotation_rad - wanted.rotation_rad).norm(), 1e-14) << name;
    }
    EXPECT_LT(relative_pose_error(chain, {}, field({}, 20), field({}, 20), {}).vector().norm(), 1e-14) << name;
  }
}

/// What is left after first order falls with the square of the errors: 10 um and 50 urad leave a few nm.
TEST(RotaryErrors, TheDeviationAtTheTipAgreesWithTheExactMachineOnEverySide) {
  testing::Noise noise(11);
  for (auto& [name, both] : twins())
    for (const double size : {1.0, 0.1}) {
      give_errors(both, [size](IndexedPosition at) { return field(at, size); });
      const KinematicChain chain(both.machine);
      double worst = 0;
      for (int k = 0; k < 100; ++k) {
        const IndexedPosition at = degrees(noise.uniform(-110, 110), noise.uniform(0, 360));
        const Vector3d tip = 150 * Vector3d(noise.uniform(-1, 1), noise.uniform(-1, 1), noise.uniform(-1, 1));
        const double length = noise.uniform(0, 200);
        const PoseError e = relative_pose_error(chain, at, field(at, size), field({}, size), {tip, length});
        const Vector3d wanted = both.exact.deviation_mm(exact_state(both.machine, at, tip, length));
        worst = std::max(worst, (displacement_mm(e, tip) - wanted).norm());
      }
      EXPECT_LT(worst, 1e-4 * size * size) << name;
    }
}

TEST(RotaryErrors, TheJacobianIsTheSlopeOfTheExactDeviation) {
  testing::Noise noise(12);
  constexpr double kStep = 1e-3;
  for (auto& [name, both] : twins()) {
    const KinematicChain chain(both.machine);
    for (int k = 0; k < 5; ++k) {
      const IndexedPosition at = degrees(noise.uniform(-110, 110), noise.uniform(5, 355));
      const Vector3d tip(60, -45, 130);
      const double length = 120;
      const RelativeErrorJacobian j = relative_error_jacobian(chain, at, {tip, length});
      for (const bool reference : {false, true})
        for (Eigen::Index i = 0; i < 12; ++i) {
          Vector3d slope = Vector3d::Zero();
          for (const double step : {kStep, -kStep}) {
            give_errors(both, [&, step](IndexedPosition p) {
              const bool at_reference = p == IndexedPosition{};
              const Eigen::Matrix<double, 12, 1> e =
                  at_reference == reference ? Eigen::Matrix<double, 12, 1>(step * Eigen::Matrix<double, 12, 1>::Unit(i))
                                            : Eigen::Matrix<double, 12, 1>(Eigen::Matrix<double, 12, 1>::Zero());
              return RotaryErrors{PoseError::from_vector(e.head<6>()), PoseError::from_vector(e.tail<6>())};
            });
            slope += both.exact.deviation_mm(exact_state(both.machine, at, tip, length)) / (2 * step);
          }
          const Vector3d found = displacement_jacobian(tip) * (reference ? j.reference : j.here).col(i);
          EXPECT_LT((found - slope).norm(), 1e-3) << name << (reference ? " reference " : " here ") << i;
        }
    }
  }
}

TEST(RotaryErrors, AxesThatDoNotCrossGiveLevers) {
  const KinematicChain chain(twin("w C' A' Y' b X Z t", {{'C', {Vector3d::UnitZ(), {58, 0, 0}}}}).machine);
  const RelativeErrorJacobian j = relative_error_jacobian(chain, degrees(0, 0), {});
  const Vector6d e = j.here.col(6 + 4) * 10e-6;  // EBC about (58, 0, 0): R's origin rises by 58 mm x 10 urad
  EXPECT_NEAR(e[2], 58 * 10e-6, 1e-15);
  EXPECT_NEAR(e[4], 10e-6, 1e-18);
}

/// The 144 x 12 design of constant errors over a 4 x 6 grid.
Eigen::MatrixXd constants_design(const KinematicChain& chain) {
  Eigen::MatrixXd w(144, 12);
  Eigen::Index row = 0;
  for (const double a : {0, -30, -60, -90})
    for (const double c : {0, 60, 120, 180, 240, 300}) {
      const RelativeErrorJacobian j = relative_error_jacobian(chain, degrees(a, c), {});
      w.middleRows<6>(row) = j.here + j.reference;
      row += 6;
    }
  return w;
}

TEST(RotaryErrors, TwelveConstantsHaveRankEight) {
  const Eigen::VectorXd s = singular_values(constants_design(KinematicChain(twin("w C' A' Y' b X Z t").machine))).s;
  EXPECT_GT(s[7], 3);
  EXPECT_LT(s[8], 1e-13);
  // Singular values 9.8 9.8 9.6 9.6 3.7 3.7 3.1 3.1 0 0 0 0.
  const double printed[8] = {9.8, 9.8, 9.6, 9.6, 3.7, 3.7, 3.1, 3.1};
  for (Eigen::Index k = 0; k < 8; ++k) EXPECT_NEAR(s[k], printed[k], .05) << k;
}

TEST(RotaryErrors, TwelveConstantsHaveRankEightOnEveryTableMachine) {
  for (const auto& [name, both] : twins()) {
    if (!both.exact.tool_axes.empty()) continue;
    Eigen::MatrixXd w = constants_design(KinematicChain(both.machine));
    w.middleCols<3>(3) /= 100, w.middleCols<3>(9) /= 100;  // angles at a lever of 0.1 m
    EXPECT_EQ(orthonormal_columns(w, 1e-9).cols(), 8) << name;
  }
}

/// The joint design of the sample calibration: 219 readings, 23 poses of six unknowns and 15 spots; the points where a
/// perfect machine would find the spots touched at the reference pose.
struct JointDesign {
  Eigen::MatrixXd x;
  std::vector<Vector3d> p, n;
  std::vector<IndexedPosition> at;
};

JointDesign replica_design() {
  JointDesign design;
  std::vector<std::pair<double, double>> poses;
  std::vector<std::string> spots;
  struct Row {
    Eigen::Index pose, spot;
  };
  std::vector<Row> index;
  std::map<std::string, Vector3d> set_up_w_mm;
  const KinematicChain chain(twin("w C' A' Y' b X Z t").machine);
  for (const testing::ObservationRow& row : testing::replica_observations()) {
    const auto place = [](auto& list, const auto& value) {
      const auto found = std::ranges::find(list, value);
      const auto at = found - list.begin();
      if (found == list.end()) list.push_back(value);
      return at;
    };
    const bool reference = row.A_deg == 0 && row.C_deg == 0;
    index.push_back({reference ? -1 : place(poses, std::pair(row.A_deg, row.C_deg)), place(spots, row.point)});
    if (reference) set_up_w_mm.emplace(row.point, *row.xyz_mm);
    design.at.push_back(degrees(row.A_deg, row.C_deg));
    design.p.push_back(chain.r_from_w(design.at.back()) * set_up_w_mm.at(row.point));
    design.n.push_back(*row.n);
  }
  const auto pose_columns = static_cast<Eigen::Index>(6 * poses.size());
  design.x = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(index.size()),
                                   pose_columns + static_cast<Eigen::Index>(spots.size()));
  for (std::size_t r = 0; r < index.size(); ++r) {
    const auto row = static_cast<Eigen::Index>(r);
    if (index[r].pose >= 0) {
      Eigen::Matrix<double, 1, 6> g = design.n[r].transpose() * displacement_jacobian(design.p[r]);
      g.tail<3>() /= 100;  // angles at a lever of 0.1 m
      design.x.block<1, 6>(row, 6 * index[r].pose) = g;
    }
    design.x(row, pose_columns + index[r].spot) = 1;
  }
  return design;
}

TEST(RotaryErrors, TheJointDesignOfTheReplicaHasFullRank) {
  const JointDesign design = replica_design();
  EXPECT_EQ(design.x.rows(), 219);
  EXPECT_EQ(design.x.cols(), 153);
  EXPECT_EQ(orthonormal_columns(design.x, 1e-9).cols(), 153);
}

TEST(RotaryErrors, WhatIsRigidWithinAPoseCannotBeSeenBesideFreePoses) {
  const JointDesign design = replica_design();
  const Eigen::MatrixXd q = orthonormal_columns(design.x, 1e-9);
  const auto visible = [&](auto value) {
    Eigen::VectorXd z(design.x.rows());
    for (std::size_t r = 0; r < design.p.size(); ++r)
      z[static_cast<Eigen::Index>(r)] = value(design.p[r], design.n[r], design.at[r].a.in_radians());
    return (z - q * (q.transpose() * z)).norm() / z.norm();
  };
  using V = const Vector3d&;
  EXPECT_LT(visible([](V, V n, double a) { return n.z() * std::sin(a); }), 1e-13) << "sag";
  EXPECT_LT(visible([](V, V n, double) { return n.x(); }), 1e-13) << "ball offset";
  const auto lobing = [](V, V n, double) { return (1 - n.z() * n.z()) * std::cos(3 * std::atan2(n.y(), n.x())); };
  EXPECT_LT(visible(lobing), 1e-13) << "three lobes a turn";
  EXPECT_LT(visible([](V, V n, double) { return n.z() * n.z(); }), 1e-13) << "pretravel along the stylus";
  EXPECT_LT(visible([](V, V n, double) { return std::abs(n.z()); }), 1e-13);
  EXPECT_LT(visible([](V p, V n, double) { return n.dot(p); }), 1e-13) << "uniform scale";
  EXPECT_GT(visible([](V p, V n, double) { return n.x() * p.y(); }), .1) << "squareness";
  EXPECT_LT(visible([](V p, V n, double) { return n.x() * p.y() - n.y() * p.x(); }), 1e-13) << "a turn of the frame";
}

}  // namespace
}  // namespace trunnion
