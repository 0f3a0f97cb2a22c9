#include <gtest/gtest.h>

#include <cmath>

#include "compensation/at_reference.h"
#include "compensation/controller_names.h"
#include "compensation/controllers/linuxcnc.h"
#include "compensation/verification.h"
#include "error.h"
#include "sample_models.h"
#include "units/angle.h"

// Where the machine is set up and its compensation switched on, the tables move nothing.

namespace trunnion {
namespace {

constexpr double kSplineLeaves_mm = 2e-5;
constexpr double kLeastSquaresLeave_mm = 3e-3;

using compensation_test::random_model;
using compensation_test::replica_model;
using compensation_test::trunnion_machine;

/// The largest that is added to the commands at A = C = 0, over the corners of the volume.
AtRest at_rest(const CompensationTask& task, const PlayedCompensation& played) {
  AtRest most;
  for (int corner = 0; corner < 8; ++corner) {
    Situation s;
    for (int k = 0; k < 3; ++k) s.point_r_mm[k] = (corner >> k) % 2 == 0 ? -150 : 150;
    const AxisCorrection c = played.at(s);
    most.linear_mm = std::max(most.linear_mm, c.linear_mm.norm());
    most.deviation_mm = std::max(most.deviation_mm, remaining({}, task.chain, s, c).position_mm.norm());
    most.rotary_rad = std::max({most.rotary_rad, std::abs(c.tilt_rad), std::abs(c.turn_rad)});
  }
  return most;
}

/// Half of the last digit of every number that is added up there.
AtRest rounding_of(const std::string& controller) {
  const double three = std::sqrt(3.0), corner_mm = 260;
  AtRest half{1e-10, 1e-13};  // fanuc-30i: zeros are written as zeros, as in every axis' own table
  // A constant, A's error and C's: 7 decimals of mm, 10 of rad; and products of two errors of 35 urad at the corner.
  if (controller == "isg-twincat") half.linear_mm = three * 3 * (0.5e-7 + 0.5e-10 * corner_mm) + 1e-6;
  // The axes' own columns are zero; those inserted leave what the format loses where C's errors change with A.
  if (controller == "heidenhain") half.linear_mm = 20e-3;
  // A spline through the map, not through its zero, with nodes 30 deg apart.
  if (controller == "linuxcnc") half = {kSplineLeaves_mm, 2 * kSplineLeaves_mm / corner_mm};
  // Maps and levers are least squares over the volume: held at zero they would lose a tenth and more everywhere. C,
  // which does not tilt a level tool, and the levers then make up for each other.
  if (controller == "sinumerik-840d" || controller == "aerotech") return {30e-3, 150e-6, kLeastSquaresLeave_mm};
  half.deviation_mm = half.linear_mm + corner_mm * half.rotary_rad;
  return half;
}

class ReferencePose : public ::testing::TestWithParam<std::string> {
 protected:
  const Controller& controller = controller_named(GetParam());
  Machine machine = trunnion_machine(GetParam());
};

TEST_P(ReferencePose, IsWhereTheTablesMoveNothing) {
  const AtRest half = rounding_of(GetParam());
  for (const Model& model : {replica_model(machine), random_model(machine, 31), random_model(machine, 32)})
    for (const double spacing : {30.0, 10.0}) {
      const CompensationTask task(machine, model, {}, controller.questions);
      const AtRest found = at_rest(task, *controller.play(controller.emit(task, Angle::degrees(spacing), {}), task));
      RecordProperty("um_and_urad", std::to_string(found.linear_mm * 1e3) + " " +
                                        std::to_string(found.rotary_rad * 1e6) + " " +
                                        std::to_string(found.deviation_mm * 1e3));
      EXPECT_LE(found.linear_mm, half.linear_mm) << spacing;
      EXPECT_LE(found.rotary_rad, half.rotary_rad) << spacing;
      EXPECT_LE(found.deviation_mm, half.deviation_mm) << spacing;
    }
}

TEST_P(ReferencePose, IsToldInTheVerification) {
  const TableSet set = make_tables(controller, machine, replica_model(machine), {});
  ASSERT_TRUE(set.verification.at_reference);
  EXPECT_LE(set.verification.at_reference->linear_mm, rounding_of(GetParam()).linear_mm);
  EXPECT_NE(verification_text(set.verification, machine).find("at A 0 C 0, where it is switched on"),
            std::string::npos);
}

/// EEC is switched on by itself (MD32700) after CEC.
TEST(ReferencePoseOfSinumerik, IsZeroInEachAxisOwnTable) {
  const Controller& controller = controller_named("sinumerik-840d");
  const Machine machine = trunnion_machine("sinumerik-840d");
  for (const Model& model : {replica_model(machine), random_model(machine, 33)}) {
    const CompensationTask task(machine, model, {}, controller.questions);
    std::vector<TableFile> files = controller.emit(task, Angle::degrees(15), {});
    std::erase_if(files, [](const TableFile& file) { return !file.name.ends_with("_EEC.INI"); });
    ASSERT_EQ(files.size(), 2U);
    EXPECT_LE(at_rest(task, *controller.play(files, task)).rotary_rad, 0.5e-7 * kDegree_rad);
  }
}

TEST(ReferencePoseOfLinuxcnc, IsZeroInTheJointTablesForStockKinematics) {
  const Machine machine = trunnion_machine();
  for (const Model& model : {replica_model(machine), random_model(machine, 31)}) {
    const CompensationTask task(machine, model, {}, {{}, controller_named("linuxcnc").questions.numbers});
    for (const TableFile& file : controller_named("linuxcnc").emit(task, Angle::degrees(10), {})) {
      if (!file.name.starts_with("joint_tables/") || !file.name.ends_with(".comp")) continue;
      for (const int sense : {1, -1})
        EXPECT_NEAR(joint_correction(read_joint_table(file), 0, sense), 0, 1e-9) << file.name;
    }
  }
}

/// Where A = 0 is no node, its value is that between nodes; the nearest function that has it leaves nothing over that
/// another such function could take.
TEST(AtReference, HoldsTheNearestFunctionAtItsValueBetweenNodes) {
  const PiecewiseLinear tilt(even_nodes(-70, 40, 20), Boundary::hold), turn(even_nodes(0, 360, 45), Boundary::repeat);
  const std::vector<double> tilt_at = tilt.sample_points(2), turn_at = turn.sample_points(2);
  WorkingVolume volume;
  volume.a = {Angle::degrees(-70), Angle::degrees(40)};
  const AtReference reference(volume, tilt, tilt_at, turn, turn_at);
  const auto n = [](const std::vector<double>& v) { return static_cast<Eigen::Index>(v.size()); };
  Eigen::VectorXd samples(n(tilt_at));
  for (Eigen::Index s = 0; s < samples.size(); ++s) samples[s] = std::cos(0.05 * tilt_at[static_cast<std::size_t>(s)]);
  const Eigen::MatrixXd project = tilt.projector(tilt_at);
  const Eigen::VectorXd held = project * reference.tilt(samples);
  EXPECT_NEAR(tilt.weights(0).dot(held), 0, 1e-12);
  EXPECT_NEAR((held - tilt.projector(tilt_at, 0) * samples).norm(), 0, 1e-12) << "the same as by the projector";
  // Its residual is square to every function on these nodes that is zero at 0.
  Eigen::MatrixXd hats(n(tilt_at), n(tilt.nodes()));
  for (Eigen::Index s = 0; s < hats.rows(); ++s) hats.row(s) = tilt.weights(tilt_at[static_cast<std::size_t>(s)]);
  const Eigen::VectorXd against = hats.transpose() * (samples - hats * held), at_zero = tilt.weights(0);
  EXPECT_NEAR((against - at_zero * (at_zero.dot(against) / at_zero.squaredNorm())).norm(), 0, 1e-12);
  // Over both axes, to a value that is not zero.
  const Eigen::MatrixXd both = reference.both(samples * Eigen::RowVectorXd::Ones(n(turn_at)), 0.25);
  EXPECT_NEAR(tilt.weights(0).dot(project * both * turn.projector(turn_at).transpose() * turn.weights(0)), 0.25, 1e-12);
}

TEST(AtReference, AsksNothingWhereTheVolumeDoesNotReachIt) {
  const PiecewiseLinear tilt(even_nodes(-70, -20, 10), Boundary::hold), turn(even_nodes(0, 360, 45), Boundary::repeat);
  WorkingVolume volume;
  volume.a = {Angle::degrees(-70), Angle::degrees(-20)};
  const AtReference reference(volume, tilt, tilt.nodes(), turn, turn.nodes());
  const Eigen::VectorXd samples = Eigen::VectorXd::LinSpaced(static_cast<Eigen::Index>(tilt.nodes().size()), 1, 2);
  EXPECT_FALSE(reference.reached());
  EXPECT_EQ(reference.tilt(samples), samples);
}

INSTANTIATE_TEST_SUITE_P(Tables, ReferencePose, ::testing::ValuesIn(controller_names()), controller_label);

}  // namespace
}  // namespace trunnion
