#include <gmock/gmock.h>

#include <algorithm>
#include <set>

#include "compensation/controller_names.h"
#include "error.h"
#include "loaded_control.h"

// The commissioning tests of section 9.3, done on the emulator of a control that is what one answer says: the small
// table gives the reading that its text promises for that answer and another for every other, and what the text warns
// of - a sign, a unit, an order of indices - gives yet another, so that whoever reads the indicator can tell.

namespace trunnion {
namespace {

using compensation_test::Loaded;

constexpr double kRead_mm = 1e-5;  // a hundredth of a micrometre
constexpr double kRead_deg = 1e-7;
using Answers = std::map<std::string, ProfileValue>;

/// The text of a commissioning file as the folder has it, made by a machine file that says nothing of its control.
std::string small_table(const std::string& controller, const std::string& name, const Answers& believed = {}) {
  Machine machine = compensation_test::trunnion_machine(controller);
  machine.profile = believed;
  const Model nothing;
  const CompensationTask task(machine, nothing, {}, controller_named(controller).questions);
  const auto files = controller_named(controller).commissioning(task);
  const auto found = std::ranges::find(files, name, &TableFile::name);
  EXPECT_NE(found, files.end()) << name;
  return found == files.end() ? "" : found->text;
}

/// A file of a set that has nothing to correct.
std::string empty_table(const std::string& controller, const std::string& name, const Answers& believed = {}) {
  Machine machine = compensation_test::trunnion_machine(controller);
  machine.profile = believed;
  const Model nothing;
  const CompensationTask task(machine, nothing, {}, controller_named(controller).questions);
  const auto files = controller_named(controller).emit(task, Angle::degrees(30), {});
  const auto found = std::ranges::find(files, name, &TableFile::name);
  EXPECT_NE(found, files.end()) << name;
  return found == files.end() ? "" : found->text;
}

/// `text` with every `from` made `to`; there is one.
std::string planted(std::string text, const std::string& from, const std::string& to) {
  std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  for (; at != std::string::npos; at = text.find(from, at + to.size())) text.replace(at, from.size(), to);
  return text;
}

// SINUMERIK ----------------------------------------------------------------------------------------------------------

Loaded sag(const std::string& text, const Answers& control = {}) {
  Loaded bench("sinumerik-840d", control);
  bench.load({{"CEC.INI", text}});
  return bench;
}

double y_mm(const Loaded& bench) { return bench.at(-30, 0).linear_mm.y(); }

TEST(SinumerikCommissioning, OnePeakTellsTheSignOfASagTable) {
  const std::string peak = small_table("sinumerik-840d", "one_peak_CEC.INI");
  EXPECT_NEAR(y_mm(sag(peak, {{"cec_sign", std::string("add")}})), 0.02, kRead_mm);
  EXPECT_NEAR(y_mm(sag(peak, {{"cec_sign", std::string("subtract")}})), -0.02, kRead_mm);
  EXPECT_NEAR(sag(peak).at(0, 0).linear_mm.norm(), 0, kRead_mm);
  EXPECT_NEAR(y_mm(sag(planted(peak, "=0.02", "=20"))), 20, kRead_mm) << "um";
  EXPECT_NEAR(y_mm(sag(planted(peak, "OUTPUT_AXIS[0]=(AX2)", "OUTPUT_AXIS[0]=(AX1)"))), 0, kRead_mm) << "another axis";
  EXPECT_NEAR(y_mm(sag(planted(planted(planted(peak, "[0,1]=", "[0,9]="), "[0,0]=", "[0,1]="), "M17\n",
                               "$AN_CEC[0,0]=0\nM17\n"))),
              0, kRead_mm)
      << "nodes counted from one";
}

TEST(SinumerikCommissioning, OneProductTellsWhatItStandsForAndWhetherItsFactorMustBeOn) {
  const std::string product = small_table("sinumerik-840d", "product_CEC.INI");
  const std::string instead = "instead of the table's own value", beside = "beside the table's own value",
                    off = "works while switched off", on = "must be switched on";
  const std::tuple<std::string, std::string, double> readings[] = {
      {instead, off, 0.01}, {beside, off, 0.03}, {instead, on, 0}, {beside, on, 0.02}};
  for (const auto& [how, factor, reading] : readings) {
    const Loaded bench = sag(product, {{"cec_product", how}, {"cec_factor", factor}});
    EXPECT_NEAR(y_mm(bench), reading, kRead_mm) << how << ", " << factor;
    EXPECT_NEAR(bench.at(-30, 0).linear_mm.x(), 0, kRead_mm) << "the factor moves nothing by itself";
  }
  EXPECT_NEAR(y_mm(sag(planted(product, "MULT_BY_TABLE[0]=2", "MULT_BY_TABLE[0]=1"))), 0.0004, kRead_mm)
      << "an index where a number belongs: the table by itself";
  EXPECT_NEAR(sag(planted(product, "TABLE_ENABLE[1]=0", "TABLE_ENABLE[1]=1")).at(-30, 0).linear_mm.x(), 0.5, kRead_mm)
      << "what the text warns of";
}

TEST(SinumerikCommissioning, AVectorAndAnOffsetTellWhatTheTransformationTakes) {
  const std::string peak = small_table("sinumerik-840d", "one_peak_CEC.INI");
  // The point that stands at X +100 with C at 180, where the control goes more than before.
  const auto moved = [&](const Answers& control, const Answers& written, const std::string& from,
                         const std::string& to) {
    Loaded bench("sinumerik-840d", control);
    bench.load(
        {{"CEC.INI", peak}, {"TRAFO5.INI", planted(empty_table("sinumerik-840d", "TRAFO5.INI", written), from, to)}});
    return Eigen::Vector3d(bench.at(0, 180, {100, 0, 50}).linear_mm);
  };
  const std::string nominal = "AXIS2_1[0]=0.000000000000", more = "AXIS2_1[0]=0.000100000000";
  const Answers against = {{"trafo5_axes", std::string("against the axis")}},
                along = {{"trafo5_axes", std::string("along the axis")}};
  EXPECT_NEAR(moved(against, against, nominal, more).z(), 0.02, kRead_mm);
  EXPECT_NEAR(moved(along, along, nominal, more).z(), -0.02, kRead_mm);
  EXPECT_NEAR(moved(against, against, nominal, "AXIS2_1[0]=0.005729577951").z(), 1.146, 0.01) << "in degrees";
  const std::string joint = "JOINT_OFFSET_PART_1[1]=0.0000000", part = "PART_OFFSET_1[1]=0.0000000";
  Loaded bench("sinumerik-840d");
  std::string offset = planted(empty_table("sinumerik-840d", "TRAFO5.INI"), joint, "JOINT_OFFSET_PART_1[1]=0.0200000");
  offset = planted(offset, "TRAFO5_" + part, "TRAFO5_PART_OFFSET_1[1]=-0.0200000");
  bench.load({{"CEC.INI", peak}, {"TRAFO5.INI", offset}});
  EXPECT_NEAR(bench.at(0, 180, {100, 0, 50}).linear_mm.y(), 0.04, kRead_mm);
  Loaded other("sinumerik-840d", {{"trafo5_joint", std::string("JOINT_OFFSET")}});
  EXPECT_THROW(other.load({{"CEC.INI", peak}, {"TRAFO5.INI", offset}}), InputError)
      << "a datum that this control has not";
}

// ISG, TwinCAT -------------------------------------------------------------------------------------------------------

Loaded volc(const std::string& table, const Answers& control = {}, const std::string& negate = "FALSE") {
  std::string list = empty_table("isg-twincat", "volcomp0.lis");
  list = planted(list, "negate FALSE", "negate " + negate);
  Loaded bench("isg-twincat", control);
  bench.load({{"volcomp0.lis", list}, {"trunnion.csv", table}});
  return bench;
}

const Answers kErrors = {{"volc_sense", std::string("values are errors")}},
              kAdded = {{"volc_sense", std::string("values are added to the command")}};

TEST(IsgCommissioning, OnePeakTellsTheSenseOfAllValuesAndTheOrderOfTheArguments) {
  const std::string peak = small_table("isg-twincat", "one_peak.csv");
  const auto x_mm = [](const Loaded& bench) { return bench.at(-30, 90).linear_mm.x(); };
  EXPECT_NEAR(x_mm(volc(peak, kErrors)), 0.02, kRead_mm);
  EXPECT_NEAR(x_mm(volc(peak, kAdded)), -0.02, kRead_mm);
  EXPECT_NEAR(volc(peak).at(0, 90).linear_mm.norm(), 0, kRead_mm);
  EXPECT_NEAR(volc(peak).at(-30, 0).linear_mm.norm(), 0, kRead_mm);
  EXPECT_NEAR(x_mm(volc(planted(peak, "A C EXC", "C A EXC"))), 0, kRead_mm) << "arguments exchanged";
  EXPECT_NEAR(x_mm(volc(planted(peak, " 0.02", " 20"))), 20, kRead_mm) << "um";
  EXPECT_NEAR(x_mm(volc(peak, kErrors, "TRUE")), -0.02, kRead_mm) << "negate";
  EXPECT_NEAR(x_mm(volc(planted(peak, "EXC", "EYC"))), 0, kRead_mm) << "another error";
}

TEST(IsgCommissioning, AYawTellsWhereAnErrorStands) {
  const std::string yaw = small_table("isg-twincat", "yaw_peak.csv");
  const auto x_mm = [](const Loaded& bench) { return bench.at(-30, 0, {0, 100, 0}).linear_mm.x(); };
  EXPECT_NEAR(x_mm(volc(yaw, kErrors)), -0.0100, kRead_mm);
  EXPECT_NEAR(x_mm(volc(yaw, kAdded)), 0.0100, kRead_mm);
  // An error that turns with A is one of C.
  EXPECT_NEAR(x_mm(volc("A ECC\n-60 0\n-30 0.0001\n0 0\n", kErrors)), -0.00866, kRead_mm);
  EXPECT_NEAR(x_mm(volc(planted(yaw, "0.0001\n", "0.0057296\n"), kErrors)), -0.573, 1e-3) << "in degrees";
}

// HEIDENHAIN ---------------------------------------------------------------------------------------------------------

Loaded tnc(const std::string& tilt, const std::string& rows, const Answers& control = {}) {
  Loaded bench("heidenhain", control);
  bench.load({{"AXIS_A.COM", tilt},
              {"AXIS_C.COM", small_table("heidenhain", "turn_peak_AXIS_C.COM")},
              {"CONFIG.CMA", empty_table("heidenhain", "CONFIG.CMA")},
              {"KINEMATICS_COMP.TXT", rows}});
  return bench;
}

const Answers kDeviations = {{"com_sign", std::string("error")}},
              kCorrections = {{"com_sign", std::string("correction")}};

TEST(HeidenhainCommissioning, APeakInTheAxisOwnColumnTellsItsSign) {
  const std::string peak = small_table("heidenhain", "own_peak_AXIS_A.COM"),
                    rows = small_table("heidenhain", "yaw_peak_KINEMATICS_COMP.TXT");
  const Loaded error = tnc(peak, rows, kDeviations), correction = tnc(peak, rows, kCorrections);
  EXPECT_NEAR(error.tilt_deg(-30), -0.005, kRead_deg);
  EXPECT_NEAR(correction.tilt_deg(-30), 0.005, kRead_deg);
  EXPECT_NEAR(error.turn_deg(30), -0.005, kRead_deg);
  EXPECT_NEAR(correction.turn_deg(30), 0.005, kRead_deg);
  EXPECT_NEAR(error.tilt_deg(0), 0, kRead_deg);
  EXPECT_NEAR(tnc(planted(peak, "+0.0050", "+0.0001"), rows).tilt_deg(-30), -0.0001, kRead_deg) << "rad";
  EXPECT_NEAR(tnc(planted(peak, "A             C1", "C1            A "), rows).tilt_deg(-30), 0, kRead_deg)
      << "another column";
}

TEST(HeidenhainCommissioning, AYawTellsTheUnitOfAngularColumnsAndThatTheTableIsLinear) {
  const std::string peak = small_table("heidenhain", "yaw_peak_AXIS_A.COM"),
                    rows = small_table("heidenhain", "yaw_peak_KINEMATICS_COMP.TXT");
  const auto x_mm = [](const Loaded& bench, double a_deg) { return bench.at(a_deg, 0, {0, 100, 0}).linear_mm.x(); };
  EXPECT_NEAR(x_mm(tnc(peak, rows, kDeviations), -30), -0.00873, kRead_mm);
  EXPECT_NEAR(x_mm(tnc(peak, rows, kDeviations), -15), -0.00436, kRead_mm);
  EXPECT_NEAR(x_mm(tnc(peak, rows, kCorrections), -30), 0.00873, kRead_mm);
  EXPECT_NEAR(x_mm(tnc(planted(peak, "+0.0050", "+0.2865"), rows), -30), -0.5, 1e-3) << "in rad";
  EXPECT_NEAR(x_mm(tnc(planted(peak, "C5            C6", "C6            C5"), rows), -30), 0, kRead_mm)
      << "columns exchanged";
}

/// BACKLASH 0.005 in every row, as the text asks.
TEST(HeidenhainCommissioning, BacklashTellsValueFromDifference) {
  std::string peak = small_table("heidenhain", "own_peak_AXIS_A.COM");
  const std::string rows = small_table("heidenhain", "yaw_peak_KINEMATICS_COMP.TXT");
  const std::size_t column = peak.find("BACKLASH") - peak.find("NR   ");
  for (const char* begin : {"\n0    ", "\n1    ", "\n2    "}) peak.replace(peak.find(begin) + 1 + column, 7, "+0.0050");
  EXPECT_NEAR(tnc(peak, rows, {{"com_backlash", std::string("value in negative travel")}}).tilt_deg(-30, -1), -0.005,
              kRead_deg);
  EXPECT_NEAR(tnc(peak, rows, {{"com_backlash", std::string("difference to positive travel")}}).tilt_deg(-30, -1),
              -0.010, kRead_deg);
}

// FANUC --------------------------------------------------------------------------------------------------------------

Loaded fanuc(const std::string& parameters, const Answers& control = {}) {
  Loaded bench("fanuc-30i", control);
  bench.load({{"PARAM.TXT", parameters}});
  return bench;
}

constexpr double kUnit_deg = 1e-4;

TEST(FanucCommissioning, OnePitchTellsTheSignAndThatPointsAreIncrements) {
  const std::string pitch = small_table("fanuc-30i", "one_pitch_PARAM.TXT");
  const Loaded adds = fanuc(pitch, {{"pitch_sign", std::string("add")}}),
               subtracts = fanuc(pitch, {{"pitch_sign", std::string("subtract")}});
  EXPECT_NEAR(adds.turn_deg(60), 7 * kUnit_deg, kRead_deg);
  EXPECT_NEAR(subtracts.turn_deg(60), -7 * kUnit_deg, kRead_deg);
  for (const Loaded* bench : {&adds, &subtracts}) EXPECT_NEAR(bench->turn_deg(90), 0, kRead_deg);
  EXPECT_NEAR(adds.turn_deg(45), 3.5 * kUnit_deg, kRead_deg) << "spread evenly";
  // Taken for the errors themselves the points say up by 7, down by 14, up by 7: -7 at 90.
  std::string whole = planted(planted(pitch, "N3623A5P1;", "N3623A5P2;"), "N10502P7", "N10502P3");
  whole = planted(planted(whole, "N10503P-7", "N10503P-7"), "N10504P0", "N10504P4");
  EXPECT_NEAR(fanuc(whole).turn_deg(90), -8 * kUnit_deg, kRead_deg);
  EXPECT_NEAR(fanuc(planted(pitch, "N3623A5P1;", "N3623A5P10;")).turn_deg(60), 70 * kUnit_deg, kRead_deg) << "3623";
  EXPECT_NEAR(fanuc(planted(planted(pitch, "N10502P7", "N10502P0"), "N10501P0", "N10501P7")).turn_deg(60),
              7 * kUnit_deg, kRead_deg);
  EXPECT_NEAR(fanuc(planted(planted(pitch, "N10502P7", "N10502P0"), "N10501P0", "N10501P7")).turn_deg(30),
              7 * kUnit_deg, kRead_deg)
      << "points counted from one";
  EXPECT_NEAR(adds.turn_deg(30), 0, kRead_deg);
}

TEST(FanucCommissioning, TwoVectorsTellWhichAxisTheyLeadTo) {
  const std::string pitch = small_table("fanuc-30i", "one_pitch_PARAM.TXT");
  const auto with = [&](const std::string& places) {
    return fanuc(pitch.substr(0, pitch.size() - 2) + places + "%\n");
  };
  const Loaded right = with("N19701P0.0200;\nN19704P-0.0200;\n"), exchanged = with("N19704P0.0200;\nN19701P-0.0200;\n");
  const Eigen::Vector3d moved = right.at(-90, 0, {30, 40, 50}).linear_mm;
  EXPECT_NEAR(moved.y(), 0.02, kRead_mm);
  EXPECT_NEAR(moved.z(), 0.02, kRead_mm);
  EXPECT_NEAR(right.at(0, 0, {30, 40, 50}).linear_mm.norm(), 0, kRead_mm);
  EXPECT_NEAR(exchanged.at(-90, 0, {30, 40, 50}).linear_mm.y(), -0.02, kRead_mm) << "vectors exchanged";
}

/// C's points at 3626 and on.
std::string both_ways(const std::string& pitch, bool upwards) {
  std::string text = planted(pitch, "N3623A5P1;", "N3623A5P1;\nN3626A5P700;\nN3627A5P0;");
  text.resize(text.size() - 2);
  for (int k = 0; k <= 12; ++k) {
    const int from = upwards ? k : 12 - k;
    text += "N" + std::to_string(10700 + k) + "P" + (from == 2 ? "7" : from == 3 ? "-7" : "0") + ";\n";
  }
  return text + "%\n";
}

TEST(FanucCommissioning, PointsForNegativeTravelTellHowTheyAreCounted) {
  const std::string pitch = small_table("fanuc-30i", "one_pitch_PARAM.TXT");
  const Loaded upwards = fanuc(both_ways(pitch, true)), downwards = fanuc(both_ways(pitch, false));
  EXPECT_NEAR(upwards.turn_deg(60, 1), 7 * kUnit_deg, kRead_deg);
  EXPECT_NEAR(upwards.turn_deg(60, -1), 7 * kUnit_deg, kRead_deg) << "alike from both sides";
  EXPECT_NEAR(downwards.turn_deg(60, -1), 0, kRead_deg) << "counted the other way the pitch is not at 60";
}

TEST(FanucCommissioning, TheReferenceTellsWhat3627Counts) {
  std::string text = both_ways(small_table("fanuc-30i", "one_pitch_PARAM.TXT"), true);
  text = planted(planted(text, "N3623A5P1;", "N3623A5P2;"), "N3627A5P0;", "N3627A5P10;");
  text = planted(planted(text, "P7;", "P0;"), "P-7;", "P0;");
  EXPECT_NEAR(fanuc(text, {{"pitch_reference", std::string("in units of 3623")}}).turn_deg(0, -1), 20 * kUnit_deg,
              kRead_deg);
  EXPECT_NEAR(fanuc(text, {{"pitch_reference", std::string("in detection units")}}).turn_deg(0, -1), 10 * kUnit_deg,
              kRead_deg);
}

// AEROTECH -----------------------------------------------------------------------------------------------------------

Loaded aerotech(const std::string& text, const Answers& control = {}) {
  Loaded bench("aerotech", control);
  bench.load({{"trunnion.cal", text}});
  return bench;
}

TEST(AerotechCommissioning, OnePeakTellsSignOrderAndTheSenseOfEncoders) {
  const std::string peak = small_table("aerotech", "one_peak.cal");
  const auto x_mm = [](const Loaded& bench) { return bench.at(-60, 90).linear_mm.x(); };
  EXPECT_NEAR(x_mm(aerotech(peak, {{"cal_sign", std::string("add")}})), 0.02, kRead_mm);
  EXPECT_NEAR(x_mm(aerotech(peak, {{"cal_sign", std::string("subtract")}})), -0.02, kRead_mm);
  EXPECT_NEAR(aerotech(peak).at(0, 90).linear_mm.norm(), 0, kRead_mm);
  EXPECT_NEAR(aerotech(peak).at(-60, 0).linear_mm.norm(), 0, kRead_mm);
  EXPECT_NEAR(x_mm(aerotech(planted(peak, ":START2D 5 4 1 2", ":START2D 4 5 1 2"))), 0, kRead_mm) << "rows for columns";
  EXPECT_NEAR(x_mm(aerotech(planted(peak, ":START2D 5 4 1 2", ":START2D 5 4 2 1"))), 0, kRead_mm) << "another output";
  EXPECT_NEAR(x_mm(aerotech(planted(peak, "PRIMARY/1000", "PRIMARY"))), 20, kRead_mm) << "mm";
  // Encoders that count otherwise than the machine file says.
  EXPECT_NEAR(x_mm(aerotech(peak, {{"encoder_sense_C", -1.0}})), 0, kRead_mm);
  EXPECT_NEAR(x_mm(aerotech(peak, {{"encoder_sense_A", -1.0}})), 0, kRead_mm);
  EXPECT_NEAR(x_mm(aerotech(peak, {{"encoder_sense_X", -1.0}})), -0.02, kRead_mm);
  // A table made for encoders as they are is right again.
  for (const char* axis : {"encoder_sense_C", "encoder_sense_A", "encoder_sense_X"})
    EXPECT_NEAR(x_mm(aerotech(small_table("aerotech", "one_peak.cal", {{axis, -1.0}}), {{axis, -1.0}})), 0.02,
                kRead_mm);
}

// All ----------------------------------------------------------------------------------------------------------------

class Commissioning : public ::testing::TestWithParam<std::string> {};

TEST_P(Commissioning, SmallTablesDoNotDependOnWhatIsBelieved) {
  const Controller& controller = controller_named(GetParam());
  if (!controller.commissioning) return;
  const auto files_of = [&](const Answers& believed) {
    Machine machine = compensation_test::trunnion_machine(GetParam());
    machine.profile = believed;
    const Model nothing;
    return controller.commissioning(CompensationTask(machine, nothing, {}, controller.questions));
  };
  const std::vector<TableFile> usual = files_of({});
  for (const ProfileItem& item : controller.questions.items)
    for (const std::string& answer : item.answers)
      if (item.key != "comptab_prefix") {  // is written, not read from an indicator
        EXPECT_EQ(files_of({{item.key, answer}}), usual) << item.key << ": " << answer;
      }
}

INSTANTIATE_TEST_SUITE_P(Tables, Commissioning, ::testing::ValuesIn(controller_names()), controller_label);

}  // namespace
}  // namespace trunnion
