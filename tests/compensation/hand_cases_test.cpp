#include <gmock/gmock.h>

#include <string>

#include "error.h"
#include "loaded_control.h"
#include "units/angle.h"

// What each control does with a file, worked out on paper from its manuals' rules and not from our emitters. The files
// are written out in full, the arithmetic stands above each number. First order: errors of 1e-5 rad and 0.01 mm leave
// products of 1e-7 mm.

namespace trunnion {
namespace {

using compensation_test::Loaded;

constexpr double kByHand_mm = 2e-6;
constexpr double kByHand = 1e-12;

/// X, Y, Z in um.
MATCHER_P3(MovesUm, x, y, z, "") {
  *result_listener << "moves " << (1e3 * arg.linear_mm).transpose() << " um";
  return (arg.linear_mm - 1e-3 * Eigen::Vector3d(x, y, z)).norm() < kByHand_mm;
}

// SINUMERIK ----------------------------------------------------------------------------------------------------------

/// A stands 0.0010 deg too far at 30 deg: a positive value drives the axis back. The end value is held.
TEST(SinumerikByHand, AnEncoderTableIsTakenAway) {
  Loaded bench("sinumerik-840d");
  bench.load({{"AX4_EEC.INI",
               "%_N_AX4_EEC_INI\nCHANDATA(1)\n$AA_ENC_COMP[0,0,AX4]=0.0004\n$AA_ENC_COMP[0,1,AX4]=0.0\n"
               "$AA_ENC_COMP[0,2,AX4] = +0.0010 ; a comment\n$AA_ENC_COMP[0, 3, AX4]=0.0015\n"
               "$AA_ENC_COMP[0,4,AX4]=0.0\n$AA_ENC_COMP_STEP[0,AX4]=30.0\n$AA_ENC_COMP_MIN[0,AX4]=-30.0\n"
               "$AA_ENC_COMP_MAX[0,AX4]=90.0\n$AA_ENC_COMP_IS_MODULO[0,AX4]=0\nM17\n"}});
  EXPECT_NEAR(bench.tilt_deg(30), -0.0010, kByHand);
  EXPECT_NEAR(bench.tilt_deg(0), 0, kByHand);
  EXPECT_NEAR(bench.tilt_deg(15), -0.0005, kByHand);   // half of 0.0010
  EXPECT_NEAR(bench.tilt_deg(40), -0.00116667, 1e-8);  // 0.0010 + (10/30) 0.0005
  EXPECT_NEAR(bench.tilt_deg(-30), -0.0004, kByHand);
  EXPECT_NEAR(bench.tilt_deg(-100), -0.0004, kByHand);  // node 0, held
  EXPECT_NEAR(bench.tilt_deg(100), 0, kByHand);         // node 4, held
  EXPECT_EQ(bench.turn_deg(30), 0);
  EXPECT_THAT(bench.at(30, 0, {10, 20, 30}), MovesUm(0, 0, 0));
}

/// C's table repeats: -60 deg is 300, half way from node 2 (240) at -0.003 to node 3 (360 = 0) at 0.001.
TEST(SinumerikByHand, AModuloTableRepeats) {
  Loaded bench("sinumerik-840d");
  bench.load({{"AX5_EEC.INI",
               "$AA_ENC_COMP[0,0,AX5]=0.001\n$AA_ENC_COMP[0,1,AX5]=0.002\n$AA_ENC_COMP[0,2,AX5]=-0.003\n"
               "$AA_ENC_COMP[0,3,AX5]=0.001\n$AA_ENC_COMP_STEP[0,AX5]=120\n$AA_ENC_COMP_MIN[0,AX5]=0\n"
               "$AA_ENC_COMP_MAX[0,AX5]=360\n$AA_ENC_COMP_IS_MODULO[0,AX5]=1\nM17\n"}});
  EXPECT_NEAR(bench.turn_deg(-60), 0.001, kByHand);   // -(-0.003 + 0.001)/2
  EXPECT_NEAR(bench.turn_deg(480), -0.002, kByHand);  // 120
  EXPECT_NEAR(bench.turn_deg(-240), -0.002, kByHand);
}

std::string sag(const std::string& t, const std::string& input, const std::string& output, const std::string& nodes,
                const std::string& rest) {
  return nodes + "$AN_CEC_INPUT_AXIS[" + t + "]=(" + input + ")\n$AN_CEC_OUTPUT_AXIS[" + t + "]=(" + output + ")\n" +
         rest;
}

/// Y over A at -30, 0, 30, 60, 90 deg: 4, 0, -2, -5, -9 um.
const std::string kSagOfY =
    sag("0", "AX4", "AX2",
        "$AN_CEC[0,0]=0.004\n$AN_CEC[0,1]=0.0\n$AN_CEC[0,2]=-0.002\n$AN_CEC[0,3]=-0.005\n$AN_CEC[0,4]=-0.009\n",
        "$AN_CEC_STEP[0]=30.0\n$AN_CEC_MIN[0]=-30.0\n$AN_CEC_MAX[0]=90.0\n$AN_CEC_IS_MODULO[0]=0\n"
        "$SN_CEC_TABLE_ENABLE[0]=1\n");
const std::string kBothWays = "$AN_CEC_DIRECTION[0]=0\n", kAlone = "$AN_CEC_MULT_BY_TABLE[0]=0\n";

TEST(SinumerikByHand, ASagTableActsOnAnotherAxisWithTheSignOfTheProfile) {
  Loaded adds("sinumerik-840d", {{"cec_sign", std::string("add")}}),
      subtracts("sinumerik-840d", {{"cec_sign", std::string("subtract")}});
  const TableFile file{"CEC.INI", "%_N_NC_CEC_INI\nCHANDATA(1)\n" + kSagOfY + kBothWays + kAlone + "M17\n"};
  adds.load({file});
  subtracts.load({file});
  EXPECT_THAT(adds.at(45, 0), MovesUm(0, -3.5, 0));  // half way from -2 to -5
  EXPECT_THAT(subtracts.at(45, 0), MovesUm(0, 3.5, 0));
  EXPECT_THAT(adds.at(-70, 0), MovesUm(0, 4, 0));
  EXPECT_THAT(adds.at(120, 0), MovesUm(0, -9, 0));
  EXPECT_EQ(adds.at(45, 0).tilt_rad, 0);
}

TEST(SinumerikByHand, ASagTableMayActInOneDirectionOfItsInputAxisOnly) {
  Loaded bench("sinumerik-840d");
  bench.load({{"CEC.INI", kSagOfY + "$AN_CEC_DIRECTION[0]=-1\n" + kAlone + "M17\n"}});
  EXPECT_THAT(bench.at(30, 0, {0, 0, 0}, 1, -1), MovesUm(0, 0, 0));
  EXPECT_THAT(bench.at(30, 0, {0, 0, 0}, -1, 1), MovesUm(0, -2, 0));
}

/// MULT_BY_TABLE holds a number, and numbers begin at 1 where indices begin at 0: 2 is the table of index 1, which
/// holds 0.002 X. At A 60, X 100 the product is -5 um x 0.2 = -1 um.
TEST(SinumerikByHand, AProductTakesItsFactorByNumber) {
  const std::string factor =
      sag("1", "AX1", "AX2", "$AN_CEC[1,0]=-0.4\n$AN_CEC[1,1]=0.4\n",
          "$AN_CEC_STEP[1]=400\n$AN_CEC_MIN[1]=-200\n$AN_CEC_MAX[1]=200\n$AN_CEC_DIRECTION[1]=0\n"
          "$AN_CEC_MULT_BY_TABLE[1]=0\n$AN_CEC_IS_MODULO[1]=0\n");
  const std::string both = kSagOfY + kBothWays + "$AN_CEC_MULT_BY_TABLE[0]=2\n" + factor;
  const TableFile off{"CEC.INI", both + "$SN_CEC_TABLE_ENABLE[1]=0\nM17\n"},
      on{"CEC.INI", both + "$SN_CEC_TABLE_ENABLE[1]=1\nM17\n"};
  Loaded instead("sinumerik-840d", {{"cec_product", std::string("instead of the table's own value")}});
  instead.load({off});
  EXPECT_THAT(instead.at(60, 0, {100, 0, 0}), MovesUm(0, -1, 0));
  EXPECT_THAT(instead.at(60, 0, {-100, 0, 0}), MovesUm(0, 1, 0));
  // Beside its own value: -5 - 1.
  Loaded beside("sinumerik-840d", {{"cec_product", std::string("beside the table's own value")}});
  beside.load({off});
  EXPECT_THAT(beside.at(60, 0, {100, 0, 0}), MovesUm(0, -6, 0));
  // A factor that is on moves Y by itself: 0.2 mm.
  instead.load({on});
  EXPECT_THAT(instead.at(60, 0, {100, 0, 0}), MovesUm(0, 199, 0));
  // Where a factor must be on and is off, nothing is left of the product.
  Loaded must("sinumerik-840d", {{"cec_factor", std::string("must be switched on")}});
  must.load({off});
  EXPECT_THAT(must.at(60, 0, {100, 0, 0}), MovesUm(0, 0, 0));
}

// ISG, TwinCAT -------------------------------------------------------------------------------------------------------

const std::string kVolcList =
    "# axis mapping\nX 1\nY 2\nZ 3\nA 4\nC 5\nworkpiece_axes 2\ninterpolation GRID\nenable_splicing FALSE\n"
    "file[0] trunnion.csv\nfile_format[0] ISG_CSV\n";
const std::string kVolcTable =
    "// constants, then A errors, then C errors over (A,C)\n"
    "Y0A Z0A B0A C0A X0C Y0C A0C B0C\n0.0120 -0.0080 0.000031 -0.000012 0.0035 0.0021 0.000008 0.000015\n#\n"
    "A EXA EYA EZA EAA EBA ECA\n-30 0.0010 0.0040 -0.0010 0.0000070 0.000004 0.000001\n0   0 0 0 0 0 0\n"
    "90  0.0020 -0.0090 0.0030 0 -0.000006 0.000002\n#\nA C EXC EYC EZC EAC EBC ECC\n-30 0   0 0 0 0 0 0\n"
    "-30 180 0.0009 -0.0018 0.0000 0.000003 0 0\n-30 360 0 0 0 0 0 0\n0  0   0 0 0 0 0 0\n"
    "0  180 0.0010 -0.0020 0.0000 0.000003 0 0\n0  360 0 0 0 0 0 0\n90 0   0.0005 0 0 0 0 0\n"
    "90 180 0.0012 -0.0024 0.0001 0.000003 0 0\n90 360 0.0005 0 0 0 0 0\n";

/// At A 90, C 180, tip (100, 50, -20), in um and urad, constants and tables added:
///   A: d (2, -9 + 12, 3 - 8) = (2, 3, -5), e (0, -6 + 31, 2 - 12) = (0, 25, -10),
///      e x q = (25 (-20) + 10 (50), -10 (100), -25 (100)) = (0, -1000, -2500) nm
///   C: d (1.2 + 3.5, -2.4 + 2.1, 0.1) = (4.7, -0.3, 0.1), e (3 + 8, 15, 0),
///      in A's frame q is (x, z, -y) = (100, -20, -50), e x that = (15 (-50), -11 (-50), 11 (-20) - 15 (100))
///      = (-750, 550, -1720) nm; together (3.95, 0.25, -1.62), in R (x, -z, y): (3.95, 1.62, 0.25)
/// and the sum is (5.95, 3.62, -7.25), by which the tool follows the work.
TEST(IsgByHand, TheToolFollowsTheWorkByTheErrorsOfBothAxes) {
  Loaded bench("isg-twincat", {}, "w C' A' b X Y Z t");
  bench.load({{"volcomp0.lis", kVolcList}, {"trunnion.csv", kVolcTable}});
  EXPECT_THAT(bench.at(90, 180, {100, 50, -20}), MovesUm(5.95, 3.62, -7.25));
  EXPECT_EQ(bench.at(90, 180, {100, 50, -20}).tilt_rad, 0);
  bench.load({{"volcomp0.lis", kVolcList + "negate TRUE\n"}, {"trunnion.csv", kVolcTable}});
  EXPECT_THAT(bench.at(90, 180, {100, 50, -20}), MovesUm(-5.95, -3.62, 7.25));
}

/// Half way in A and in C at once: (0 + 1.0 + 0.5 + 1.2) / 4 = 0.675 um along X, which A does not turn.
/// C -90 is 270: the rows of 180 and 360. Beyond 90 the edge.
TEST(IsgByHand, AMapIsBilinear) {
  Loaded bench("isg-twincat", {}, "w C' A' b X Y Z t");
  bench.load({{"volcomp0.lis", kVolcList},
              {"trunnion.csv", "A C EXC\n0 0 0\n0 180 0.0010\n0 360 0\n90 0 0.0005\n90 180 0.0012\n90 360 0.0005\n"}});
  EXPECT_THAT(bench.at(45, 90), MovesUm(0.675, 0, 0));
  EXPECT_THAT(bench.at(45, -90), MovesUm(0.675, 0, 0));
  EXPECT_THAT(bench.at(110, 180), MovesUm(1.2, 0, 0));
  EXPECT_THAT(bench.at(90, 45), MovesUm(0.675, 0, 0));  // 0.5 + (1.2 - 0.5)/4
}

/// X stands 4 um too far and 1 um too high at 100 mm: the command goes back by both, half of it at 50.
TEST(IsgByHand, ErrorsOfALinearAxisAreTakenAway) {
  Loaded bench("isg-twincat", {}, "w C' A' b X Y Z t");
  bench.load({{"volcomp0.lis", kVolcList}, {"trunnion.csv", "X EXX EZX\n0 0 0\n100 0.004 0.001\n"}});
  EXPECT_THAT(bench.at(0, 0, {100, 7, 7}), MovesUm(-4, 0, -1));
  EXPECT_THAT(bench.at(0, 0, {50, 0, 0}), MovesUm(-2, 0, -0.5));
}

// HEIDENHAIN ---------------------------------------------------------------------------------------------------------

const std::string kComA =
    "BEGIN AXIS_A.COM MM\n"
    "NR   AXISPOS       BACKLASH      A         C1        C2        C6\n"
    "0    -30.0000                    +0.0004             +0.0040\n"
    "1    +0.0000                     +0.0000             +0.0000\n"
    "2    +30.0000                    +0.0010             +0.0020   +0.0020\n"
    "[END]\n";
const std::string kComC =
    "BEGIN AXIS_C.COM MM\n"
    "NR   AXISPOS       C         C1        C2        C3\n"
    "0    +0.0000       +0.0000\n"
    "1    +90.0000      -0.0030   +0.0030   +0.0040   +0.0050\n"
    "2    +360.0000     +0.0000\n"
    "[END]\n";
const std::string kRowsOfBoth =
    "NR   DOC   KEY       AXIS  COORD  COMPTAB\n0 EYA Trans Y A..C2\n1 ECA Trans C A..C6\n2 MachAxis A\n"
    "3 EXC Trans X C..C1\n4 EYC Trans Y C..C2\n5 EZC Trans Z C..C3\n6 MachAxis C\n";

const TableFile kAssigned{"CONFIG.CMA",
                          "BEGIN CONFIG.CMA\nNR   ACTIVE  A         C\n0            AXIS_C    AXIS_A\n"
                          "1    *       AXIS_A    AXIS_C\n[END]\n"};

/// The axis' own column is an error and is taken away; what stands in COMPTAB moves the work, and the tool follows.
/// A 30: EYA 2 um, ECA 0.002 deg = 34.907 urad, at (100, 40, 0): (-40, 100) x 34.907 nm = (-1.396, 3.491) um.
TEST(HeidenhainByHand, OwnColumnsAreTakenAwayAndInsertedErrorsFollowed) {
  Loaded bench("heidenhain");
  bench.load({{"AXIS_A.COM", kComA}, {"AXIS_C.COM", kComC}, {"KINEMATICS_COMP.TXT", kRowsOfBoth}, kAssigned});
  EXPECT_NEAR(bench.tilt_deg(30), -0.0010, kByHand);
  EXPECT_NEAR(bench.tilt_deg(-15), -0.0002, kByHand);
  EXPECT_NEAR(bench.turn_deg(90), 0.0030, kByHand);
  EXPECT_NEAR(bench.turn_deg(225), 0.0015, kByHand);  // half way from 90 to 360
  EXPECT_NEAR(bench.turn_deg(-135), 0.0015, kByHand);
  EXPECT_THAT(bench.at(30, 0, {100, 40, 0}), MovesUm(-1.396, 2 + 3.491, 0));
  EXPECT_THAT(bench.at(15, 0, {100, 40, 0}), MovesUm(-0.698, 1 + 1.745, 0));
  EXPECT_THAT(bench.at(-60, 0, {100, 40, 0}), MovesUm(0, 4, 0));  // held
}

/// Errors of C stand in A's frame. At A -90 that has its Y along -Z and its Z along Y of R: (3, 4, 5) is (3, 5, -4).
/// A's own EYA of 4 um (held below -30) comes to it.
TEST(HeidenhainByHand, ErrorsOfCTurnWithA) {
  Loaded bench("heidenhain");
  bench.load({{"AXIS_A.COM", kComA}, {"AXIS_C.COM", kComC}, {"KINEMATICS_COMP.TXT", kRowsOfBoth}, kAssigned});
  EXPECT_THAT(bench.at(-90, 90), MovesUm(3, 4 + 5, -4));
  EXPECT_THAT(bench.at(0, 90), MovesUm(3, 4, 5));
}

TEST(HeidenhainByHand, ValuesMayBeCorrectionsAndColumnsNotInsertedAreNotPlayed) {
  Loaded bench("heidenhain", {{"com_sign", std::string("correction")}});
  bench.load({{"AXIS_A.COM", kComA},
              {"AXIS_C.COM", kComC},
              {"KINEMATICS_COMP.TXT",
               "NR   DOC   KEY       AXIS  COORD  COMPTAB\n0 MachAxis A\n"
               "3 EXC Trans X C..C1\n6 MachAxis C\n"},
              kAssigned});
  EXPECT_NEAR(bench.tilt_deg(30), 0.0010, kByHand);
  EXPECT_THAT(bench.at(30, 90), MovesUm(-3, 0, 0));
}

/// C stands 3 mdeg too far coming from below and 5 coming from above; or 2 further than from below.
TEST(HeidenhainByHand, BacklashIsTheAxisItselfComingFromTheOtherSide) {
  const std::string head = "BEGIN AXIS_C.COM MM\nNR   AXISPOS       BACKLASH  C\n";
  const std::string whole =
                        head + "0    +0.0000       +0.0050   +0.0030\n1    +360.0000     +0.0050   +0.0030\n[END]\n",
                    further =
                        head + "0    +0.0000       +0.0020   +0.0030\n1    +360.0000     +0.0020   +0.0030\n[END]\n";
  Loaded value("heidenhain"),
      difference("heidenhain", {{"com_backlash", std::string("difference to positive travel")}});
  value.load({{"AXIS_A.COM", kComA}, {"AXIS_C.COM", whole}, {"KINEMATICS_COMP.TXT", kRowsOfBoth}, kAssigned});
  difference.load({{"AXIS_A.COM", kComA}, {"AXIS_C.COM", further}, {"KINEMATICS_COMP.TXT", kRowsOfBoth}, kAssigned});
  for (const Loaded* bench : {&value, &difference}) {
    EXPECT_NEAR(bench->turn_deg(100, 1), -0.003, kByHand);
    EXPECT_NEAR(bench->turn_deg(100, -1), -0.005, kByHand);
    EXPECT_NEAR(bench->tilt_deg(30, -1), -0.001, kByHand) << "A's table has no values for it";
  }
}

// FANUC --------------------------------------------------------------------------------------------------------------

/// C every 45 deg in thousandths of a degree, from its reference on: errors 0 1 3 4 2 0 -2 -1 0, so that 0 -1 -3 -4 -2
/// 0 2 1 0 is to be added and the increments are -1 -2 -1 2 2 2 -1 -1. A: 0 at its reference, 3 further at -45.
const std::string kPitch =
    "%\nN3620A4P60;\nN3621A4P58;\nN3622A4P61;\nN3623A4P1;\nN3624A4P45.0;\nN10058P0;\nN10059P5;\nN10060P-3;\nN10061P0;\n"
    "N3620A5P160;\nN3621A5P160;\nN3622A5P168;\nN3623A5P1;\nN3624A5P45.0;\nN3625A5P360.0;\nN10160P-1;\nN10161P-1;\n"
    "N10162P-2;\nN10163P-1;\nN10164P2;\nN10165P2;\nN10166P2;\nN10167P-1;\nN10168P-1;\n";

TEST(FanucByHand, IncrementsAddUpFromTheReferenceOn) {
  Loaded bench("fanuc-30i", {{"detection_unit_deg", 0.001}});
  bench.load({{"PARAM.TXT", kPitch + "%\n"}});
  const double wanted[] = {0, -1, -3, -4, -2, 0, 2, 1, 0};
  for (int k = 0; k <= 8; ++k) EXPECT_NEAR(bench.turn_deg(45 * k), 0.001 * wanted[k], kByHand) << 45 * k;
  EXPECT_NEAR(bench.turn_deg(67.5), -0.002, kByHand);
  EXPECT_NEAR(bench.turn_deg(-45), 0.001, kByHand);
  // On the way down from 60 to 59 the increment of 60 (-3) is passed backwards, from 59 to 58 that of 59 (+5).
  EXPECT_NEAR(bench.tilt_deg(-45), 0.003, kByHand);
  EXPECT_NEAR(bench.tilt_deg(-90), -0.002, kByHand);
  EXPECT_NEAR(bench.tilt_deg(0), 0, kByHand);
  // What follows shares the file: 3623 makes it 7 times as much, the profile turns it round.
  std::string larger = kPitch;
  larger.replace(larger.find("N3623A5P1;"), 10, "N3623A5P7;");
  bench.load({{"PARAM.TXT", larger + "%\n"}});
  EXPECT_NEAR(bench.turn_deg(135), -0.028, kByHand);
  Loaded subtracts("fanuc-30i", {{"detection_unit_deg", 0.001}, {"pitch_sign", std::string("subtract")}});
  subtracts.load({{"PARAM.TXT", kPitch + "%\n"}});
  EXPECT_NEAR(subtracts.turn_deg(135), 0.004, kByHand);
}

/// A's line is 20 um higher in Y than R's origin. A -90 turns about it: o - R o = (0, 20, 0) - (0, 0, -20) um. C's line
/// is 10 um beside A's in X: half a turn, (10, 0, 0) - (-10, 0, 0).
TEST(FanucByHand, ToolCentrePointControlFollowsThePlacesOfTheAxes) {
  Loaded bench("fanuc-30i", {{"detection_unit_deg", 0.001}});
  bench.load({{"PARAM.TXT", kPitch + "N19680P12;\nN19700P0.0;\nN19701P0.02;\nN19702P0.0;\nN19703P0.01;\nN19704P-0.02;\n"
                                     "N19705P0.0;\n%\n"}});
  EXPECT_THAT(bench.at(-90, 0, {30, 40, 50}), MovesUm(0, 20, 20));
  EXPECT_THAT(bench.at(0, 180, {30, 40, 50}), MovesUm(20, 0, 0));
  EXPECT_THAT(bench.at(0, 0, {30, 40, 50}), MovesUm(0, 0, 0));
}

/// The same pitch on the way down, from points 200 on, but -3 in units of 3623 at the reference coming from above: with
/// a magnification of 2 that is 0.002 x (-3) at 0, and 0.002 x (-3 - 4) at 135 deg.
TEST(FanucByHand, NegativeTravelHasPointsOfItsOwn) {
  std::string both = kPitch;
  both.replace(both.find("N3623A5P1;"), 10, "N3623A5P2;\nN3626A5P200;\nN3627A5P-3;");
  const int down[] = {-1, -1, -2, -1, 2, 2, 2, -1, -1};
  for (int k = 0; k <= 8; ++k) both += "N" + std::to_string(10200 + k) + "P" + std::to_string(down[k]) + ";\n";
  Loaded bench("fanuc-30i", {{"detection_unit_deg", 0.001}});
  bench.load({{"PARAM.TXT", both + "%\n"}});
  EXPECT_NEAR(bench.turn_deg(0, -1), -0.006, kByHand);
  EXPECT_NEAR(bench.turn_deg(135, -1), -0.014, kByHand);
  EXPECT_NEAR(bench.turn_deg(135, 1), -0.008, kByHand);
  Loaded plain("fanuc-30i", {{"detection_unit_deg", 0.001}, {"pitch_reference", std::string("in detection units")}});
  plain.load({{"PARAM.TXT", both + "%\n"}});
  EXPECT_NEAR(plain.turn_deg(135, -1), -0.011, kByHand);
}

// AEROTECH -----------------------------------------------------------------------------------------------------------

/// Rows over C (axis 5) every 90 deg from 0, columns over A (4) every 30 deg from -30, X and Y in um.
const std::string kCal =
    "' (A,C) map, X and Y\n:START2D 5 4 1 2 90 30 5\n"
    ":START2D POSUNIT=PRIMARY CORUNIT=PRIMARY/1000 OFFSETROW=0 OFFSETCOL=30\n"
    "0.4 4.0  0.0 0.0  -0.2 -2.0  -0.5 -5.0  -0.9 -9.0\n3.4 4.1  3.0 0.2   2.8 -1.9   2.5 -4.8   2.1 -8.8\n"
    "1.4 3.8  1.0 -0.3  0.8 -2.2   0.5 -5.3   0.1 -9.3\n-1.6 4.0 -2.0 0.0 -2.2 -2.0  -2.5 -5.0  -2.9 -9.0\n"
    "0.4 4.0  0.0 0.0  -0.2 -2.0  -0.5 -5.0  -0.9 -9.0\n:END\n";

TEST(AerotechByHand, ATableIsAddedBilinearAndHeldAtItsEnds) {
  Loaded bench("aerotech");
  bench.load({{"trunnion.cal", kCal}});
  EXPECT_THAT(bench.at(0, 90), MovesUm(3.0, 0.2, 0));
  EXPECT_THAT(bench.at(30, 180), MovesUm(0.8, -2.2, 0));
  EXPECT_THAT(bench.at(15, 45), MovesUm(1.4, -0.925, 0));  // (0 - 0.2 + 3 + 2.8)/4, (0 - 2 + 0.2 - 1.9)/4
  EXPECT_THAT(bench.at(-60, 180), MovesUm(1.4, 3.8, 0));
  EXPECT_THAT(bench.at(120, 270), MovesUm(-2.9, -9.0, 0));
  EXPECT_EQ(bench.at(15, 45).tilt_rad, 0);
  // Tables add up; NEGCOR turns one round.
  bench.load({{"trunnion.cal", kCal + kCal}});
  EXPECT_THAT(bench.at(15, 45), MovesUm(2.8, -1.85, 0));
  std::string negated = kCal;
  negated.replace(negated.find("POSUNIT"), 7, "NEGCOR POSUNIT");
  bench.load({{"trunnion.cal", negated}});
  EXPECT_THAT(bench.at(15, 45), MovesUm(-1.4, 0.925, 0));
}

/// Three outputs, of which one turns: thousandths of its primary unit, degrees. In mm without a divisor.
TEST(AerotechByHand, UnitsAreThoseOfEachOutput) {
  Loaded bench("aerotech");
  bench.load({{"trunnion.cal",
               ":START2D 5 4 4 5 180 90 2\n:START2D POSUNIT=PRIMARY CORUNIT=PRIMARY/1000 OFFSETROW=0 OFFSETCOL=90\n"
               "0 0  0 0\n5 -3  0 0\n0 0  0 0\n:END\n"
               ":START2D 1 4 1 2 100 90 2\n:START2D OUTAXIS3=3 POSUNIT=PRIMARY CORUNIT=PRIMARY OFFSETROW=0 "
               "OFFSETCOL=90\n0 0 0  0 0 0\n0.001 0.002 0.003  0 0 0\n:END\n"}});
  EXPECT_NEAR(bench.at(-90, 180).tilt_rad / kDegree_rad, 0.005, kByHand);
  EXPECT_NEAR(bench.at(-90, 180).turn_rad / kDegree_rad, -0.003, kByHand);
  EXPECT_THAT(bench.at(-90, 0, {100, 0, 0}), MovesUm(1, 2, 3));
  EXPECT_THAT(bench.at(-45, 0, {50, 0, 0}), MovesUm(0.25, 0.5, 0.75));
}

/// An encoder of X that counts against the program: the same numbers move X the other way. One of C likewise: it stands
/// at -90 for C 90, the second row from 0 in steps of -90.
TEST(AerotechByHand, PositionsAndCorrectionsFollowTheEncoders) {
  Loaded x_against("aerotech", {{"encoder_sense_X", -1.0}});
  x_against.load({{"trunnion.cal", kCal}});
  EXPECT_THAT(x_against.at(0, 90), MovesUm(-3.0, 0.2, 0));
  Loaded c_against("aerotech", {{"encoder_sense_C", -1.0}});
  std::string file = kCal;
  file.replace(file.find(" 90 30 5"), 8, " -90 30 5");
  c_against.load({{"trunnion.cal", file}});
  EXPECT_THAT(c_against.at(0, 90), MovesUm(3.0, 0.2, 0));
  Loaded subtracts("aerotech", {{"cal_sign", std::string("subtract")}});
  subtracts.load({{"trunnion.cal", kCal}});
  EXPECT_THAT(subtracts.at(0, 90), MovesUm(-3.0, -0.2, 0));
}

}  // namespace
}  // namespace trunnion
