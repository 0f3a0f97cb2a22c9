#include "compensation/controllers/linuxcnc.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "compensation/verification.h"
#include "error.h"
#include "sample_models.h"

namespace trunnion {
namespace {

using compensation_test::random_model;
using compensation_test::replica_model;
using compensation_test::trunnion_machine;

constexpr double kLeft_mm = 0.05e-3;  // what the component may leave anywhere in the working volume

const TableFile& named(const TableSet& set, const std::string& name) {
  return *std::ranges::find(set.files, name, &TableFile::name);
}

TEST(LinuxcncTables, TheComponentLeavesNothingOfTheReplicaNorOfARandomMachine) {
  const Machine machine = trunnion_machine();
  for (const Model& model : {replica_model(machine), random_model(machine, 7), random_model(machine, 8)}) {
    const Verification v = make_tables(controller_named("linuxcnc"), machine, model, {}).verification;
    EXPECT_TRUE(v.load_ready());
    EXPECT_GT(v.before.position_rms_mm, 2e-3);
    EXPECT_LT(v.tables.position_max_mm, kLeft_mm);
    EXPECT_LT(v.ideal.position_max_mm, 1e-9);
    EXPECT_NEAR(v.tables.orientation_rms_rad, v.ideal.orientation_rms_rad, 0.05e-6);
  }
}

TEST(LinuxcncTables, ACyclicErrorOfOrderSixSurvivesBecauseTheSpacingAdapts) {
  const Machine machine = trunnion_machine();
  Model model = random_model(machine, 9);
  compensation_test::add_cyclic_error(model, machine, 30);
  const Verification v = make_tables(controller_named("linuxcnc"), machine, model, {}).verification;
  EXPECT_LT(v.tables.position_max_mm, kLeft_mm);
}

TEST(LinuxcncTables, ReversalErrorsGoIntoJointTablesThatKnowTheDirection) {
  const Machine machine = trunnion_machine();
  Model model = random_model(machine, 10);
  compensation_test::add_effect(model, machine, "backlash:C", "reversal", 24, "urad");
  compensation_test::add_effect(model, machine, "backlash:A", "reversal", -17, "urad");
  const TableSet set = make_tables(controller_named("linuxcnc"), machine, model, {});
  EXPECT_LT(set.verification.tables.position_max_mm, kLeft_mm);
  const JointTable table = read_joint_table(named(set, "kinematics/joint_C.comp"));
  EXPECT_EQ(table.rows.front().forward, 0);
  EXPECT_NEAR(table.rows.front().reverse, -24e-6 * 180 / M_PI, 1e-9);
}

TEST(LinuxcncTables, WhatDependsOnALinearAxisIsCarriedToo) {
  const Machine machine = trunnion_machine();
  Model model = random_model(machine, 11);
  compensation_test::add_effect(model, machine, "linear_scale:X", "EXX", 60, "um/m");
  const Verification v = make_tables(controller_named("linuxcnc"), machine, model, {}).verification;
  EXPECT_LT(v.tables.position_max_mm, kLeft_mm);
}

TEST(LinuxcncTables, ComponentDataReadBackAreTheDataWritten) {
  const Machine machine = trunnion_machine();
  const Model model = random_model(machine, 12);
  const CompensationTask task(machine, model, {}, {});
  const KinematicsData data = kinematics_data(task, Angle::degrees(10));
  EXPECT_EQ(read_component_data({"k.comp", component_source(data, "a machine")}), data);
}

TEST(LinuxcncTables, AComponentThatLostDataIsRefused) {
  const Machine machine = trunnion_machine();
  const Model model = random_model(machine, 12);
  const CompensationTask task(machine, model, {}, {});
  std::string text = component_source(kinematics_data(task, Angle::degrees(10)), "a machine");
  const std::size_t at = text.find("error_map[tilt_count]");
  text.erase(text.find(',', at), text.find('}', at) - text.find(',', at));
  EXPECT_THROW(read_component_data({"k.comp", text}), InputError);
  EXPECT_THROW(read_component_data({"k.comp", ""}), InputError);
}

TEST(LinuxcncTables, AJointTableIsReadAsTheControlReadsIt) {
  EXPECT_EQ(read_joint_table({"j.comp", "0 1 2\n10 3 4 and more\n# no comments\n20 5 6\n"}),
            (JointTable{{{0, 1, 2}, {10, 3, 4}}}));
  try {
    read_joint_table({"j.comp", "0 1 2\n0 3 4\n"});
    FAIL() << "nominals that stand still were taken";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "j.comp:2: nominal 0 after 0, ascending ones are wanted");
  }
  std::string long_table;
  for (int k = 0; k < 257; ++k) long_table += std::to_string(k) + " 0 0\n";
  EXPECT_THROW(read_joint_table({"j.comp", long_table}), InputError);
}

TEST(LinuxcncTables, AJointTableIsPlayedWithHeldEndsDirectionAndSinglePrecision) {
  const JointTable table{{{-30, 0.001, -0.001}, {0, 0.003, 0}, {60, -0.003, 0.1}}};
  constexpr double kSingle = 1e-9;
  EXPECT_NEAR(joint_correction(table, -45, 1), 0.001, kSingle);
  EXPECT_NEAR(joint_correction(table, -15, 1), 0.002, kSingle);
  EXPECT_NEAR(joint_correction(table, -15, -1), -0.0005, kSingle);
  EXPECT_NEAR(joint_correction(table, 20, 1), 0.001, kSingle);
  EXPECT_NEAR(joint_correction(table, 99, -1), 0.1, 1e-8);
  EXPECT_NE(joint_correction(table, 99, -1), 0.1) << "values are kept in single precision";
}

TEST(LinuxcncTables, JointTablesForStockKinematicsCarryWhatTheRotaryAxesStandWrong) {
  const Machine machine = trunnion_machine();
  Model model;
  RotaryMapContent content;  // EAA and ECC alone: all of it is within reach of A and C
  for (double a = -90; a <= 0; a += 15) content.grid.a_stations.push_back(Angle::degrees(a));
  for (double c = 0; c < 360; c += 30) content.grid.c_stations.push_back(Angle::degrees(c));
  for (const Angle a : content.grid.a_stations) {
    content.grid.tilt.push_back({.rotation_rad = {40e-6 * std::sin(a.in_radians()), 0, 0}});
    for (const Angle c : content.grid.c_stations)
      content.grid.turn.push_back({.rotation_rad = {0, 0, 25e-6 * std::sin(c.in_radians())}});
  }
  model.effects.push_back(std::make_shared<RotaryErrorMap>(std::move(content), effect_context(machine)));
  const TableSet set = make_tables(controller_named("linuxcnc"), machine, model, {});
  const CompensationTask task(machine, model, {}, {});
  const auto played =
      play_linuxcnc({named(set, "joint_tables/joint_A.comp"), named(set, "joint_tables/joint_C.comp")}, task);
  const Spread left = spread(model, task.chain, pose_sample(task.volume, model, 500, 0), *played);
  EXPECT_GT(set.verification.before.position_rms_mm, 4e-3);
  EXPECT_LT(left.position_rms_mm, 0.03e-3) << "linear between nodes 5 deg apart";
}

TEST(LinuxcncTables, TheSetIsTheSameBytesEveryTimeAndSaysWhoseItIs) {
  const Machine machine = trunnion_machine();
  const Model model = replica_model(machine);
  const TableSet set = make_tables(controller_named("linuxcnc"), machine, model, {.date = "2026-11-23"});
  EXPECT_EQ(set.files, make_tables(controller_named("linuxcnc"), machine, model, {.date = "2026-11-23"}).files);
  for (const char* name : {"kinematics/trunnion_kins.comp", "LOADING.md", "kinematics/trunnion_kins.ini"})
    EXPECT_THAT(named(set, name).text, ::testing::HasSubstr("Trunnion of the tests, serial 0042, model " +
                                                            model_fingerprint(model) + ", 2026-11-23"));
}

TEST(LinuxcncTables, AHeadMachineIsRefused) {
  Machine machine = trunnion_machine();
  machine.structure = parse_structure("w C' X' b Y Z A t");
  machine.axes = default_axes(machine.structure);
  machine.work_volume.a = Range<Angle>{Angle::degrees(-90), Angle::degrees(0)};
  EXPECT_THROW(make_tables(controller_named("linuxcnc"), machine, Model{}, {}), RefusalError);
}

}  // namespace
}  // namespace trunnion
