#include "support/probing_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>

#include "linear_algebra/factors.h"
#include "support/replica.h"
#include "support/smooth_machine.h"
#include "support/undeclared_draw.h"
#include "support/undeclared_effects.h"

namespace trunnion::testing {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using ::testing::ElementsAre;
using ::testing::StartsWith;

const VirtualMachine kPerfect = perfect_machine("w C' A' Y' b X Z t");

/// Columns: six per pose other than the reference (um and urad scaled by 0.1 m), then one offset per spot.
MatrixXd joint_design(const ProbingPlan& plan) {
  std::map<std::pair<double, double>, Eigen::Index> poses;
  for (const PlannedTouch& touch : plan.touches)
    if (touch.A_deg != 0 || touch.C_deg != 0)
      poses.emplace(std::pair(-touch.A_deg, touch.C_deg), static_cast<Eigen::Index>(poses.size()));
  const auto count = static_cast<Eigen::Index>(poses.size());
  MatrixXd design = MatrixXd::Zero(static_cast<Eigen::Index>(plan.touches.size()),
                                   6 * count + static_cast<Eigen::Index>(plan.faces.size()));
  for (std::size_t i = 0; i < plan.touches.size(); ++i) {
    const PlannedTouch& touch = plan.touches[i];
    const auto row = static_cast<Eigen::Index>(i);
    const RotaryPosition q = ac_degrees(touch.A_deg, touch.C_deg);
    const Vector3d n = kPerfect.approach_r(plan.faces[touch.face], q);
    const Vector3d p = kPerfect.nominal_contact_r_mm(plan.faces[touch.face], q);
    const auto pose = poses.find({-touch.A_deg, touch.C_deg});
    if (pose != poses.end())
      design.row(row).segment<6>(6 * pose->second) << n.transpose(), p.cross(n).transpose() / 100;
    design(row, 6 * count + static_cast<Eigen::Index>(touch.face)) = 1;
  }
  return design;
}

TEST(ProbingPlan, ReplicaHas219TouchesOf15Spots) {
  const ProbingPlan plan = replica_plan();
  EXPECT_EQ(plan.faces.size(), 15U);
  EXPECT_EQ(plan.touches.size(), 219U);
  std::map<std::size_t, int> poses_of_size;
  std::map<std::pair<double, double>, std::size_t> size;
  for (const PlannedTouch& touch : plan.touches) ++size[{touch.A_deg, touch.C_deg}];
  for (const auto& [pose, touches] : size) ++poses_of_size[touches];
  EXPECT_EQ(poses_of_size, (std::map<std::size_t, int>{{15, 1}, {9, 20}, {8, 3}}));
  EXPECT_EQ(two_top_plan().touches.size(), 294U);
}

TEST(ProbingPlan, TouchesComeFromAboveOrFromTheSide) {
  for (const ProbingPlan& plan : {replica_plan(), two_top_plan()})
    for (const PlannedTouch& touch : plan.touches)
      EXPECT_LT(kPerfect.approach_r(plan.faces[touch.face], ac_degrees(touch.A_deg, touch.C_deg)).z(), .05);
}

/// The dossier's figures for such a plan: all unknowns are determined, with these standard uncertainties.
TEST(ProbingPlan, ReplicaDeterminesAllPosesAsWellAsThePublishedPlan) {
  const MatrixXd design = joint_design(replica_plan());
  ASSERT_EQ(design.cols(), 153);
  EXPECT_EQ(orthonormal_columns(design, 1e-12).cols(), 153);
  const MatrixXd covariance = Cholesky(design.transpose() * design).inverse() * .175 * .175;
  const double wanted[] = {.236, .207, .212, 1.94, 1.55, 1.58};  // um and urad
  for (int k = 0; k < 6; ++k) {
    double mean_square = 0;
    for (int pose = 0; pose < 23; ++pose) mean_square += covariance(6 * pose + k, 6 * pose + k) / 23;
    const double std = std::sqrt(mean_square) * (k < 3 ? 1 : 10);  // um per 100 mm are 10 urad
    EXPECT_NEAR(std, wanted[k], .05 * wanted[k]) << k;
  }
}

TEST(ProbingPlan, ReplicaIsBlindToWhatIsRigidWithinAPose) {
  const ProbingPlan plan = replica_plan();
  const MatrixXd design = joint_design(plan);
  const MatrixXd seen = orthonormal_columns(design, 1e-12);
  const auto visible = [&](auto&& column_of) {
    VectorXd z(design.rows());
    for (std::size_t i = 0; i < plan.touches.size(); ++i) {
      const PlannedTouch& touch = plan.touches[i];
      const RotaryPosition q = ac_degrees(touch.A_deg, touch.C_deg);
      const Face& face = plan.faces[touch.face];
      z[static_cast<Eigen::Index>(i)] = column_of(kPerfect.approach_r(face, q), kPerfect.nominal_contact_r_mm(face, q));
    }
    return (z - seen * (seen.transpose() * z)).norm() / z.norm();
  };
  EXPECT_LT(visible([](const Vector3d& n, const Vector3d& p) { return n.dot(p); }), 1e-12);
  EXPECT_LT(visible([](const Vector3d& n, const Vector3d&) { return n.z() * n.z(); }), 1e-12);
  EXPECT_LT(visible([](const Vector3d& n, const Vector3d&) { return n.x(); }), 1e-12);
  EXPECT_LT(visible([](const Vector3d& n, const Vector3d& p) { return n.x() * p.y() - n.y() * p.x(); }), 1e-12);
  EXPECT_NEAR(visible([](const Vector3d& n, const Vector3d& p) { return n.x() * p.x(); }), .52, .05);
}

TEST(ProbingPlan, ThreePassesGoForwardBackAndUp) {
  const ProbingPlan one = replica_plan();
  const ProbingPlan plan = three_passes(one);
  ASSERT_EQ(plan.touches.size(), 657U);
  EXPECT_EQ(plan.touches[219].face, one.touches.back().face);
  EXPECT_EQ(plan.touches[437].A_deg, 0);
  EXPECT_EQ(plan.touches[438].A_deg, -90);
  EXPECT_EQ(plan.touches[656].A_deg, 0);
  EXPECT_EQ(plan.touches[656].C_deg, 300);
  EXPECT_NEAR(plan.touches.back().time_s, 84 * 60, 60);
  std::map<std::pair<double, double>, std::set<int>> A_senses, C_senses;
  for (std::size_t i = 0; i < plan.touches.size(); ++i) {
    const PlannedTouch& touch = plan.touches[i];
    EXPECT_EQ(touch.order, static_cast<int>(i));
    EXPECT_EQ(touch.repeat, static_cast<int>(i / 219));
    A_senses[{touch.A_deg, touch.C_deg}].insert(touch.A_dir);
    C_senses[{touch.A_deg, touch.C_deg}].insert(touch.C_dir);
  }
  EXPECT_EQ(A_senses.at({-30, 120}).size(), 2U);
  EXPECT_EQ(C_senses.at({-30, 120}).size(), 2U);
}

TEST(ProbingPlan, SensesFollowTheLastMotionOfEachAxis) {
  ProbingPlan plan;
  plan.faces = faces_of({});
  for (const auto& [A, C] : {std::pair(0., 0.), {0., 60.}, {0., 60.}, {-30., 60.}, {-30., 0.}, {-10., 0.}})
    plan.touches.push_back({.A_deg = A, .C_deg = C});
  plan = timed(plan);
  std::vector<int> A_dir, C_dir, in_pose;
  for (const PlannedTouch& touch : plan.touches) {
    A_dir.push_back(touch.A_dir);
    C_dir.push_back(touch.C_dir);
    in_pose.push_back(touch.order_in_pose);
  }
  EXPECT_THAT(A_dir, ElementsAre(-1, -1, -1, -1, -1, 1));
  EXPECT_THAT(C_dir, ElementsAre(1, 1, 1, 1, -1, -1));
  EXPECT_THAT(in_pose, ElementsAre(0, 0, 1, 0, 0, 0));
}

TEST(ProbingPlan, VerificationStandsOffTheGridAndStartsAtTheReference) {
  const ProbingPlan plan = verification_plan(faces_of({}), {.seed = 3}, {.start_s = 2000, .first_order = 219});
  EXPECT_EQ(plan.touches.front().order, 219);
  EXPECT_GT(plan.touches.front().time_s, 2000);
  std::set<std::pair<double, double>> poses;
  for (const PlannedTouch& touch : plan.touches) {
    poses.insert({touch.A_deg, touch.C_deg});
    EXPECT_LE(touch.A_deg, 0);
    EXPECT_GE(touch.A_deg, -85);
  }
  EXPECT_EQ(poses.size(), 25U);
}

TEST(Probe, OfAPerfectMachineReadsItsNoiseAndNothingElse) {
  const ProbingPlan plan = three_passes(replica_plan());
  Noise noise(11);
  double sum = 0, squares = 0;
  const auto rows = probe(kPerfect, plan, {.sigma_mm = 2e-4}, noise);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const RotaryPosition q = ac_degrees(rows[i].A_deg, rows[i].C_deg);
    const Vector3d off = *rows[i].xyz_mm - kPerfect.nominal_contact_r_mm(plan.faces[plan.touches[i].face], q);
    const double along = off.dot(*rows[i].n);
    EXPECT_LT((off - along * *rows[i].n).norm(), 1e-12);
    sum += along;
    squares += along * along;
  }
  EXPECT_NEAR(sum / 657, 0, 4 * 2e-4 / std::sqrt(657));
  EXPECT_NEAR(std::sqrt(squares / 657), 2e-4, 4 * 2e-4 / std::sqrt(2 * 657));
}

TEST(Probe, MeetsChipsNowAndThenAndAlwaysEarly) {
  Noise noise(5);
  const ProbingPlan plan = three_passes(replica_plan());
  int chips = 0;
  const auto rows = probe(kPerfect, plan, {.chip_rate = .02}, noise);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const RotaryPosition q = ac_degrees(rows[i].A_deg, rows[i].C_deg);
    const double along =
        (*rows[i].xyz_mm - kPerfect.nominal_contact_r_mm(plan.faces[plan.touches[i].face], q)).dot(*rows[i].n);
    if (std::abs(along) < 1e-9) continue;
    ++chips;
    EXPECT_LT(along, -1.9e-3);
    EXPECT_GT(along, -20.1e-3);
  }
  EXPECT_GT(chips, 3);
  EXPECT_LT(chips, 30);
}

/// Readings of the exact machine, fitted by the linear model without noise, give the gauged pose errors to second
/// order.
TEST(Probe, ReadingsOfASmoothMachineLeadBackToItsPoseErrors) {
  const VirtualMachine machine = smooth_machine(42);
  ProbingPlan plan = replica_plan();
  Noise noise(42);
  plan.faces = as_built(plan.faces, noise, .02, 0);
  const auto rows = probe(machine, plan, {}, noise);
  VectorXd readings(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const RotaryPosition q = ac_degrees(rows[i].A_deg, rows[i].C_deg);
    readings[static_cast<Eigen::Index>(i)] =
        rows[i].n->dot(*rows[i].xyz_mm - kPerfect.nominal_contact_r_mm(plan.faces[plan.touches[i].face], q));
  }
  const VectorXd found = LeastSquares(joint_design(plan)).solve(readings);
  const GaugedMaps truth = gauged_maps(machine, {0, -30, -60, -90}, {0, 60, 120, 180, 240, 300});
  std::set<std::pair<double, double>> seen;
  Eigen::Index pose = 0;
  for (const PlannedTouch& touch : plan.touches) {
    if ((touch.A_deg == 0 && touch.C_deg == 0) || !seen.insert({touch.A_deg, touch.C_deg}).second) continue;
    const auto cell = static_cast<std::size_t>(-touch.A_deg / 30 * 6 + touch.C_deg / 60);
    const Eigen::Matrix<double, 6, 1> error = found.segment<6>(6 * pose++);
    EXPECT_LT((error.head<3>() - truth.pose[cell].translation_mm).norm(), 5e-5);
    EXPECT_LT((error.tail<3>() / 100 - truth.pose[cell].rotation_rad).norm(), 5e-7);
  }
  EXPECT_EQ(pose, 23);
}

TEST(SmoothMachine, IsTheSameForTheSameSeedAndAnotherForAnother) {
  const RotaryPosition q = ac_degrees(-40, 100);
  const AxisErrors a = smooth_machine(1).pose_error(q), b = smooth_machine(1).pose_error(q),
                   c = smooth_machine(2).pose_error(q);
  EXPECT_EQ(a.translation_mm, b.translation_mm);
  EXPECT_NE(a.translation_mm, c.translation_mm);
  EXPECT_GT(a.translation_mm.norm(), 1e-3);
  EXPECT_LT(a.translation_mm.norm(), .2);
}

TEST(SmoothMachine, OfLocationErrorsOnlyHasTheSameErrorsEverywhere) {
  const VirtualMachine machine = location_errors_only(4);
  for (char name : {'A', 'C'}) {
    const AxisErrors here = machine.axis(name).errors(ac_degrees(-40, 100)), home = machine.axis(name).errors({});
    EXPECT_EQ(here.translation_mm, home.translation_mm);
    EXPECT_EQ(here.rotation_rad, home.rotation_rad);
    EXPECT_GT(here.translation_mm.norm(), 0);
  }
}

TEST(SmoothMachine, HasAsManyHarmonicsOfCAsAsked) {
  const VirtualMachine machine = smooth_machine(6, {.C_harmonics = 3});
  double third = 0, fourth = 0;
  for (int i = 0; i < 360; ++i) {
    const double ecc = machine.axis('C').errors(ac_degrees(-20, i)).rotation_rad.z();
    third += ecc * std::cos(3 * i * std::numbers::pi / 180) / 180;
    fourth += ecc * std::cos(4 * i * std::numbers::pi / 180) / 180;
  }
  EXPECT_GT(std::abs(third), 1e-7);
  EXPECT_LT(std::abs(fourth), 1e-15);
}

TEST(UndeclaredEffects, EveryOneChangesReadings) {
  const ProbingPlan plan = three_passes(replica_plan());
  for (const std::string& id : undeclared_ids()) {
    Noise drawn(9), none(0);
    VirtualMachine machine = kPerfect;
    add_undeclared(machine, id, drawn);
    ProbingPlan warming = plan;
    record_covariates(warming, id);
    const auto with = probe(machine, warming, {}, none), without = probe(kPerfect, warming, {}, none);
    double rms_um = 0;
    for (std::size_t i = 0; i < with.size(); ++i)
      rms_um += (*with[i].xyz_mm - *without[i].xyz_mm).squaredNorm() * 1e6 / 657;
    EXPECT_GT(std::sqrt(rms_um), .1) << id;
    EXPECT_LT(std::sqrt(rms_um), 10) << id;
  }
  Noise noise(1);
  VirtualMachine machine = kPerfect;
  EXPECT_THROW(add_undeclared(machine, "gremlins", noise), std::invalid_argument);
}

TEST(GaugedMaps, AverageToZeroOverCAndAddUpToThePoseError) {
  VirtualMachine machine = smooth_machine(8);
  machine.axis('A').origin_mm = {0, 5, -20};
  machine.axis('C').origin_mm = {0, -58, 0};
  const GaugedMaps maps = gauged_maps(machine, {0, -45, -90}, {0, 70, 200, 300});
  for (std::size_t i = 0; i < 3; ++i) {
    Vector3d mean = Vector3d::Zero();
    for (std::size_t j = 0; j < 4; ++j) mean += maps.C[4 * i + j].rotation_rad;
    EXPECT_LT(mean.norm(), 1e-17);
    // Put back into Eq. (3) they give Delta, but for products of two errors.
    VirtualMachine again = perfect_machine("w C' A' Y' b X Z t");
    for (char name : {'A', 'C'}) again.axis(name).origin_mm = machine.axis(name).origin_mm;
    for (std::size_t j = 0; j < 4; ++j) {
      again.axis('A').errors = [&](const RotaryPosition&) { return maps.tilt[i]; };
      again.axis('C').errors = [&](const RotaryPosition&) { return maps.C[4 * i + j]; };
      MachineState state;
      state.rotary = ac_degrees(maps.tilt_deg[i], maps.C_deg[j]);
      const AxisErrors sum = errors_of(again.r_from_w(state) * again.r_from_w_nominal(state.rotary).inverse());
      EXPECT_LT((sum.translation_mm - maps.pose[4 * i + j].translation_mm).norm(), 5e-5);
      EXPECT_LT((sum.rotation_rad - maps.pose[4 * i + j].rotation_rad).norm(), 1e-7);
    }
  }
}

TEST(Replica, HasTheErrorsThatThePaperShows) {
  const GaugedMaps truth = replica_truth();
  EXPECT_NEAR(truth.tilt[0].rotation_rad.x(), 0, 1e-9);
  EXPECT_NEAR(truth.tilt[3].rotation_rad.x(), 2e-3 * std::numbers::pi / 180, 1e-8);
  double largest = 0;
  for (const AxisErrors& errors : truth.C) {
    largest = std::max(largest, errors.rotation_rad.head<2>().cwiseAbs().maxCoeff());
    EXPECT_LT(errors.translation_mm.norm(), 10e-3);
  }
  EXPECT_LT(largest, .5e-3 * std::numbers::pi / 180);
  EXPECT_GT(largest, .3e-3 * std::numbers::pi / 180);
}

TEST(Csv, HasTheColumnsThatRowsHave) {
  EXPECT_THAT(csv(replica_observations()),
              StartsWith("A_deg,C_deg,point,artifact,x_mm,y_mm,z_mm,nx,ny,nz,repeat,time_s,A_dir,C_dir,temperature_C\n"
                         "0,0,1S1,1,"));
  PlannedTouch where{.A_deg = -30, .C_deg = 60, .covariates = {{"load_kg", 12.5}}};
  const ObservationRow turned = rotation_row(kPerfect, where, "encoder", Vector3d::UnitX(), 3e-6);
  EXPECT_EQ(csv({turned}, 6, 'B'),
            "kind,B_deg,C_deg,artifact,mx,my,mz,value_urad,repeat,time_s,B_dir,C_dir,temperature_C,load_kg\n"
            "rotation,-30,60,encoder,1,0,0,3,0,0,-1,1,20,12.5\n");
  const ObservationRow moved = displacement_row(kPerfect, where, "ball", {100, 0, 50}, {1e-3, 0, 0}, Vector3d(0, 0, 1));
  EXPECT_NEAR(*moved.value_um, std::sin(-std::numbers::pi / 6) * std::sin(std::numbers::pi / 3), 1e-9);
  const ObservationRow posed =
      pose_row(kPerfect, {.C_deg = 90}, "target", Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity());
  EXPECT_LT((*posed.quaternion_wxyz - Eigen::Vector4d(std::sqrt(.5), 0, 0, std::sqrt(.5))).norm(), 1e-15);
}

TEST(Csv, WritesNumbersShortAndRoundTrip) {
  EXPECT_EQ(csv_number(.1), "0.1");
  EXPECT_EQ(csv_number(-0.0), "0");
  EXPECT_EQ(csv_number(-1e-12, 9), "0");
  EXPECT_EQ(csv_number(100, 9), "100");
  EXPECT_EQ(csv_number(-1.25, 9), "-1.25");
}

}  // namespace
}  // namespace trunnion::testing
