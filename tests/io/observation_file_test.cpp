#include "io/observation_file.h"

#include <gtest/gtest.h>

#include "error.h"
#include "io/machine_file.h"

namespace trunnion {
namespace {

const Machine kMachine = read_machine(TRUNNION_SOURCE_DIR "/samples/calibrate/machine.toml");

std::string refusal(const std::string& text) {
  try {
    parse_observations(text, "obs.csv", kMachine);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ObservationFile, ReadsAllFourKindsIntoInsideUnits) {
  const ObservationSet set = parse_observations(
      "kind,A_deg,C_deg,x_mm,y_mm,z_mm,nx,ny,nz,value_um,mx,my,mz,value_urad,qw,qx,qy,qz,point,sigma_um\n"
      "contact,0,90,1,2,3,0,0,-1,,,,,,,,,,P,0.5\n"
      "displacement,-30,0,1,2,3,1,0,0,4.5,,,,,,,,,,\n"
      "rotation,-30,0,,,,,,,,0,0,1,7,,,,,,2\n"
      "pose,-30,0,1,2,3,,,,,,,,,0,1,0,0,,\n",
      "obs.csv", kMachine);
  ASSERT_EQ(set.rows.size(), 4u);
  EXPECT_EQ(set.rows[0].kind, ReadingKind::contact);
  EXPECT_DOUBLE_EQ(set.rows[0].at.c.in_degrees(), 90);
  EXPECT_DOUBLE_EQ(set.rows[0].sigma, 0.5e-3);
  EXPECT_EQ(set.points[set.rows[0].point], "P");
  EXPECT_EQ(set.rows[1].kind, ReadingKind::displacement);
  EXPECT_DOUBLE_EQ(set.rows[1].value, 4.5e-3);
  EXPECT_EQ(set.rows[2].kind, ReadingKind::rotation);
  EXPECT_DOUBLE_EQ(set.rows[2].value, 7e-6);
  EXPECT_DOUBLE_EQ(set.rows[2].sigma, 2e-6);
  EXPECT_EQ(set.rows[3].kind, ReadingKind::pose);
  EXPECT_EQ(set.rows[3].orientation.coeffs(), Eigen::Quaterniond(0, 1, 0, 0).coeffs());
  EXPECT_EQ(set.rows[3].line, 5u);
}

TEST(ObservationFile, ToleratesAByteOrderMarkCommentsCrlfBlanksAndAMissingLastNewline) {
  const ObservationSet set = parse_observations(
      "\xEF\xBB\xBF# by hand\r\nC_deg, A_deg ,point,x_mm,y_mm,z_mm,nx,ny,nz\r\n\r\n 0 ,+1,P,1,2,3,1,0,0\r\n# end\r\n"
      "0,-1,P,1,2,3,1,0,0",
      "obs.csv", kMachine);
  ASSERT_EQ(set.rows.size(), 2u);
  EXPECT_EQ(set.rows[0].line, 4u);
  EXPECT_DOUBLE_EQ(set.rows[0].at.a.in_degrees(), 1);
  EXPECT_DOUBLE_EQ(set.rows[1].at.a.in_degrees(), -1);
}

TEST(ObservationFile, TakesUnknownNumericColumnsAsCovariates) {
  const ObservationSet set = parse_observations(
      "A_deg,C_deg,point,x_mm,y_mm,z_mm,nx,ny,nz,coolant_l\n0,0,P,1,2,3,1,0,0,2.5\n0,0,P,1,2,3,1,0,0,3.5\n", "obs.csv",
      kMachine);
  EXPECT_EQ(set.extra_columns, std::vector<std::string>{"coolant_l"});
  EXPECT_EQ(set.extra_values, (std::vector<double>{2.5, 3.5}));
}

TEST(ObservationFile, NormalisesAVectorThatIsAlmostAUnitVector) {
  const ObservationSet set =
      parse_observations("A_deg,C_deg,point,x_mm,y_mm,z_mm,nx,ny,nz\n0,0,P,1,2,3,0.9995,0,0\n", "obs.csv", kMachine);
  EXPECT_EQ(set.rows[0].direction, Eigen::Vector3d(1, 0, 0));
}

TEST(ObservationFile, RefusesALineWithoutEnd) {
  const std::string head = "A_deg,C_deg,point,x_mm,y_mm,z_mm,nx,ny,nz\n0,0,P,1,2,3,1,0,0\n";
  EXPECT_EQ(refusal(head + std::string(std::size_t{2} << 20, '0')),
            "obs.csv:3: a line of 2097152 bytes found, no row is that long");
}

TEST(ObservationFile, ReadsTheSampleCalibration) {
  const ObservationSet set = read_observations(TRUNNION_SOURCE_DIR "/samples/calibrate/replica.csv", kMachine);
  EXPECT_EQ(set.rows.size(), 219u);
  EXPECT_TRUE(set.has_time && set.has_tilt_sense && set.has_turn_sense && set.has_repeat && set.has_temperature);
}

}  // namespace
}  // namespace trunnion
