#include "io/machine_file.h"

#include <gtest/gtest.h>

#include "error.h"

namespace trunnion {
namespace {

const std::string kSample = TRUNNION_SOURCE_DIR "/samples/calibrate/machine.toml";

TEST(MachineFile, GivesTheSeedMachineAsItsFileDescribesIt) {
  const Machine machine = read_machine(kSample);
  EXPECT_EQ(machine.name, "Middle-size trunnion");
  EXPECT_EQ(machine.serial, "0001");
  EXPECT_EQ(machine.structure, parse_structure("w C' A' Y' b X Z t"));
  EXPECT_EQ(machine.tilt().direction, Eigen::Vector3d(1, 0, 0));
  ASSERT_TRUE(machine.tilt().range_angle.has_value());
  EXPECT_DOUBLE_EQ(machine.tilt().range_angle->low.in_degrees(), -120);
  EXPECT_TRUE(machine.turn().modulo);
  EXPECT_DOUBLE_EQ(machine.probe.sigma.in_micrometres(), 0.175);
  EXPECT_DOUBLE_EQ(machine.limits.rotary_word.in_degrees(), 0.1);
  EXPECT_FALSE(machine.work_volume.c.has_value());
}

TEST(MachineFile, MakesAUnitVectorOfADirection) {
  const Machine machine = parse_machine(
      "format='trunnion-machine'\nversion=1\nname='n'\nserial='s'\nstructure=\"w C' B' b X Y Z t\"\n"
      "[axis.B]\ndirection=[0, -2, 0]\n",
      "m.toml");
  EXPECT_EQ(machine.tilt_letter(), 'B');
  EXPECT_EQ(machine.tilt().direction, Eigen::Vector3d(0, -1, 0));
}

TEST(MachineFile, KeepsTheFreeKeysOfAProfileUnderTheirPath) {
  const Machine machine = parse_machine(
      "format='trunnion-machine'\nversion=1\nname='n'\nserial='s'\nstructure=\"w C' A' Y' b X Z t\"\n"
      "[profile]\ncycle = 'G43.4'\n[profile.tables]\nrows = 12\nready = false\n",
      "m.toml");
  EXPECT_EQ(machine.profile.at("cycle"), ProfileValue("G43.4"));
  EXPECT_EQ(machine.profile.at("tables.rows"), ProfileValue(12.0));
  EXPECT_EQ(machine.profile.at("tables.ready"), ProfileValue(false));
}

}  // namespace
}  // namespace trunnion
