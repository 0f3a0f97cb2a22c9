#include <gmock/gmock.h>

#include "compensation/controllers/sinumerik_trafo5.h"
#include "compensation/verification.h"
#include "error.h"
#include "model/effects/location_errors.h"
#include "sample_models.h"

// The vectors of the transformation: by hand where a point then goes, and against the model of a machine that has
// nothing but location errors, which they must take away whole.

namespace trunnion {
namespace {

const Controller& sinumerik() { return controller_named("sinumerik-840d"); }

const std::string kNominal =
    "$MC_TRAFO5_BASE_TOOL_1[0]=0\n$MC_TRAFO5_BASE_TOOL_1[1]=0\n$MC_TRAFO5_BASE_TOOL_1[2]=0\n"
    "$MC_TRAFO5_AXIS1_1[0]=-1\n$MC_TRAFO5_AXIS1_1[1]=0\n$MC_TRAFO5_AXIS1_1[2]=0\n";

struct Bench {
  Machine machine = compensation_test::trunnion_machine("sinumerik-840d");
  Model nothing;
  CompensationTask task{machine, nothing, {}, sinumerik().questions};

  /// Where the control goes for the point (100, 0, 50) of the table with C at 180 deg and the table level.
  Eigen::Vector3d reached(const std::string& rest) const {
    const KinematicChain believed = read_trafo5({kTrafo5File, kNominal + rest + "M17\n"}, task);
    return believed.r_from_w({Angle(), Angle::degrees(180)}) * Eigen::Vector3d(100, 0, 50);
  }
};

TEST(Trafo5, PlaysCasesWorkedOutByHand) {
  constexpr double kSecondOrder_mm = 1e-5;
  const Bench bench;
  const std::string level = "$MC_TRAFO5_AXIS2_1[0]=0\n$MC_TRAFO5_AXIS2_1[1]=0\n$MC_TRAFO5_AXIS2_1[2]=-1\n";
  // C's line 0.02 further in Y: half a turn about it puts the point 0.04 further in Y.
  EXPECT_LT((bench.reached(level + "$MC_TRAFO5_JOINT_OFFSET_PART_1[0]=0\n$MC_TRAFO5_JOINT_OFFSET_PART_1[1]=0.02\n"
                                   "$MC_TRAFO5_JOINT_OFFSET_PART_1[2]=0\n$MC_TRAFO5_PART_OFFSET_1[0]=0\n"
                                   "$MC_TRAFO5_PART_OFFSET_1[1]=-0.02\n$MC_TRAFO5_PART_OFFSET_1[2]=0\n") -
             Eigen::Vector3d(-100, 0.04, 50))
                .norm(),
            kSecondOrder_mm);
  // C leans by 0.0001 towards +X: the vector, against the axis, has -0.0001. Half a turn about (d, 0, 1) takes
  // (x, 0, z) to (-x + 2 d z, 0, z + 2 d x).
  EXPECT_LT((bench.reached("$MC_TRAFO5_AXIS2_1[0]=-0.0001\n$MC_TRAFO5_AXIS2_1[1]=0\n$MC_TRAFO5_AXIS2_1[2]=-1\n"
                           "$MC_TRAFO5_JOINT_OFFSET_PART_1[0]=0\n$MC_TRAFO5_JOINT_OFFSET_PART_1[1]=0\n"
                           "$MC_TRAFO5_JOINT_OFFSET_PART_1[2]=0\n$MC_TRAFO5_PART_OFFSET_1[0]=0\n"
                           "$MC_TRAFO5_PART_OFFSET_1[1]=0\n$MC_TRAFO5_PART_OFFSET_1[2]=0\n") -
             Eigen::Vector3d(-100 + 0.01, 0, 50 + 0.02))
                .norm(),
            kSecondOrder_mm);
}

TEST(Trafo5, FollowsTheLocationErrorsThatTheModelHas) {
  // First order in the model, exact in the control: 1e-4 rad squared at 300 mm.
  constexpr double kSecondOrder_mm = 5e-6;
  for (const char* code : {"w C' A' Y' b X Z t", "w C' B' Y' b X Z t"}) {
    Machine machine = compensation_test::trunnion_machine("sinumerik-840d");
    machine.structure = parse_structure(code);
    machine.axes = default_axes(machine.structure);
    machine.axes.at(machine.tilt_letter()).origin_mm = {3, -20, 40};
    machine.axes.at('C').origin_mm = {-5, 12, 60};
    const EffectPtr zero = make_location_errors(effect_context(machine));
    const Model nothing;
    const CompensationTask task(machine, nothing, {}, sinumerik().questions);
    for (Eigen::Index k = 0; k < 8; ++k) {
      const bool length = zero->parameters()[static_cast<std::size_t>(k)].unit == Unit::um;
      const EffectPtr one = zero->with_parameters((length ? 0.05 : 1e-4) * Eigen::VectorXd::Unit(8, k), {});
      const KinematicChain believed = read_trafo5(trafo5_file(task, *one, {1, false}), task);
      for (const Situation& s : pose_sample(task.volume, nothing, 30, 0)) {
        const Eigen::Vector3d followed =
            believed.r_from_w(s.at) * (task.chain.r_from_w(s.at).inverse() * s.point_r_mm) - s.point_r_mm;
        const PoseError e = one->at(s);
        EXPECT_LT((followed - e.translation_mm - e.rotation_rad.cross(s.point_r_mm)).norm(), kSecondOrder_mm)
            << code << " " << zero->parameters()[static_cast<std::size_t>(k)].name;
      }
    }
  }
}

TEST(Trafo5, LeavesLessThanHalfOfWhatTablesAloneLeave) {
  Machine machine = compensation_test::trunnion_machine("sinumerik-840d");
  const Model model = compensation_test::replica_model(machine);
  const double with = make_tables(sinumerik(), machine, model, {}).verification.tables.position_rms_mm;
  machine.profile["trafo5_axes"] = std::string("not to be set confirmed");
  const TableSet without = make_tables(sinumerik(), machine, model, {});
  EXPECT_LT(with, without.verification.tables.position_rms_mm / 2);
  for (const TableFile& file : without.files) EXPECT_EQ(file.name.find("TRAFO5"), std::string::npos);
}

TEST(Trafo5, RefusesVectorsThatDoNotCloseOrAreNoDirections) {
  const Bench bench;
  const EffectPtr location = make_location_errors(effect_context(bench.machine));
  const std::string right = trafo5_file(bench.task, *location, {}).text;
  const auto refused = [&](const std::string& from, const std::string& to, const std::string& message) {
    std::string text = right;
    ASSERT_NE(text.find(from), std::string::npos);
    text.replace(text.find(from), from.size(), to);
    try {
      read_trafo5({kTrafo5File, text}, bench.task);
      ADD_FAILURE() << message;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr(message));
    }
  };
  refused("PART_OFFSET_1[1]=0.0000000", "PART_OFFSET_1[1]=0.02", "add up to 0.02 mm, 0 is wanted");
  refused("AXIS2_1[2]=-1.000000000000", "AXIS2_1[2]=-1000", "a direction of length 1000, 1 is wanted");
  refused("$MC_TRAFO5_AXIS1_1[0]=", "$MC_TRAFO5_AXIS9_1[0]=", "$MC_TRAFO5_AXIS1_1[0] is missing");
}

}  // namespace
}  // namespace trunnion
