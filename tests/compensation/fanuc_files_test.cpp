#include "compensation/controllers/fanuc_files.h"

#include <gmock/gmock.h>

#include <cmath>
#include <map>

#include "compensation/verification.h"
#include "error.h"
#include "sample_models.h"

// What a FANUC refuses, refused before it gets there, with the line.

namespace trunnion {
namespace {

using compensation_test::trunnion_machine;

std::string parameters_refused(const std::string& text) {
  try {
    fanuc::read_parameters({fanuc::kParameterFile, text});
  } catch (const InputError& error) {
    return error.what();
  }
  return "taken";
}

std::string program_refused(const std::string& text) {
  try {
    fanuc::read_program({fanuc::kProgramFile, text});
  } catch (const InputError& error) {
    return error.what();
  }
  return "taken";
}

TEST(FanucFiles, AParameterFileIsTakenAsItShouldStand) {
  EXPECT_EQ(parameters_refused("%\nN3620A4P60;\nN10060P-7;\nN19701P0.0200;\n%\n"), "taken");
}

TEST(FanucFiles, WhatTheControlWouldRefuseIsRefusedWithItsLine) {
  const std::pair<const char*, const char*> cases[] = {
      {"%\r\nN19680P12;\r\n%\r\n", "PARAM.TXT:1: the line ends with CR LF, LF alone is wanted"},
      {"%\nN19680P12;\n%", "PARAM.TXT:3: the last line has no end, LF is wanted"},
      {"N19680P12;\n%\n", "PARAM.TXT:1: \"N19680P12;\" found, % alone is wanted on the first line"},
      {"%\nN19680P12;\n", "PARAM.TXT:3: the file ends, % is wanted"},
      {"%\nN19680P12;%\n", "PARAM.TXT:2: \"N19680P12;%\": % stands alone on its line"},
      {"%\nN19680P12;\n%\nN19700P0;\n", "PARAM.TXT:4: text behind the % at the end"},
      {"%\nN19680P12\n%\n", "PARAM.TXT:2: \"N19680P12\": a block ends with ;"},
      {"%\nN19680P12;;\n%\n", "PARAM.TXT:2: \"N19680P12;\": more than NAP"},
      {"%\nn19680P12;\n%\n", "PARAM.TXT:2: \"n19680P12;\": small letters, capitals are wanted"},
      {"%\n\nN19680P12;\n%\n", "PARAM.TXT:2: an empty line"},
      {"%\nN19680 P12;\n%\n", "PARAM.TXT:2: character number 32 found, capital letters, digits and + - . are wanted"},
      {"%\nP12N19680;\n%\n", "PARAM.TXT:2: \"P12N19680\": N and a number are wanted, in the order NAP"},
      {"%\nN19680;\n%\n", "PARAM.TXT:2: \"N19680\": P and a number are wanted, in the order NAP"},
      {"%\nN19701P1E-2;\n%\n", "PARAM.TXT:2: \"N19701P1E-2\": more than NAP"},
      {"%\nN19701P--1;\n%\n", "PARAM.TXT:2: address P: a number is wanted behind it"},
      {"%\nN3620A0P60;\n%\n", "PARAM.TXT:2: address A: the number of an axis, 1 to 32, is wanted"},
      {"%\nN3620P60;\n%\n", "PARAM.TXT:2: N3620: an axis is wanted"},
      {"%\nN10060A4P1;\n%\n", "PARAM.TXT:2: N10060: no parameter of an axis"},
      {"%\nN10060P1.5;\n%\n", "PARAM.TXT:2: N10060: 1.5 found, a whole number is wanted"},
      {"%\nN10060P8;\n%\n", "PARAM.TXT:2: N10060: 8 found, a pitch error from -7 to 7 is wanted"},
      {"%\nN3623A4P0;\n%\n", "PARAM.TXT:2: N3623: 0 found, a magnification from 1 to 100 is wanted"},
      {"%\nN10060P1;\nN10060P1;\n%\n", "PARAM.TXT:3: N10060 stands twice"},
  };
  for (const auto& [text, message] : cases) EXPECT_EQ(parameters_refused(text), message) << text;
}

TEST(FanucFiles, AProgramIsReadLikeTheParametersAndRefusedLikeThem) {
  const std::string head = "%\nO9000(AN EXAMPLE, 2026-11-23)\nG10L52\n", end = "G11\nM30\n%\n";
  EXPECT_EQ(program_refused(head + "N3620P4R60\nN19701R0.0200\n" + end), "taken");
  EXPECT_EQ(program_refused("%\nO9000\nN19701R0\n" + end), "G10.NC:3: \"N19701R0\" found, G10L52 is wanted");
  EXPECT_EQ(program_refused(head + "N19701R0;\n" + end), "G10.NC:4: \"N19701R0;\": more than NPR");
  EXPECT_EQ(program_refused(head + "N19701R0\r\n" + end), "G10.NC:4: the line ends with CR LF, LF alone is wanted");
  EXPECT_EQ(program_refused(head + "N19701R0\nG11\n%\n"), "G10.NC:6: \"%\" found, M30 is wanted");
  EXPECT_EQ(program_refused("%\nO9000(an example)\nG10L52\n" + end),
            "G10.NC:2: \"O9000(an example)\": small letters, capitals are wanted");
}

class FanucSet : public ::testing::Test {
 protected:
  const Controller& controller = controller_named("fanuc-30i");
  Machine machine = trunnion_machine("fanuc-30i");
  Model model = compensation_test::random_model(machine, 61);

  std::string refused(const std::vector<TableFile>& files) {
    const CompensationTask task(machine, model, {}, controller.questions);
    try {
      controller.play(files, task);
    } catch (const InputError& error) {
      return error.what();
    }
    return "taken";
  }
};

TEST_F(FanucSet, BothFilesSayTheSameOrAreRefused) {
  const CompensationTask task(machine, model, {}, controller.questions);
  auto files = controller.emit(task, Angle::degrees(30), {});
  ASSERT_EQ(files.size(), 2U);
  EXPECT_EQ(refused(files), "taken");
  std::string& program = files[1].text;
  const std::size_t at = program.find("N3620P4R60");
  ASSERT_NE(at, std::string::npos);
  program.replace(at, 10, "N3620P4R61");
  EXPECT_EQ(refused(files), "G10.NC:4: not what PARAM.TXT:2 says");
}

TEST_F(FanucSet, ARotaryAxisThatDoesNotCloseIsRefused) {
  const CompensationTask task(machine, model, {}, controller.questions);
  const auto files = controller.emit(task, Angle::degrees(30), {});
  const auto with = [&](const std::string& from, const std::string& to) {
    TableFile file = files[0];
    const std::size_t at = file.text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    file.text.replace(at, from.size(), to);
    return refused({file});
  };
  EXPECT_EQ(
      with("N3622A5P512;", "N3622A5P511;"),
      "PARAM.TXT: 3621 500, 3622 511: a rotary axis has its points from the reference (3620) on for a turn (3625) "
      "in steps of 3624");
  EXPECT_EQ(with("N3623A5", "N3626A5P700;\nN3623A5"), "PARAM.TXT: 3626 and 3627: both or neither are wanted");
  EXPECT_EQ(with("N19680P12;", "N19680P21;"), "PARAM.TXT: 19680 is 21, 12 (two table axes) is wanted");
  EXPECT_EQ(with("N3620A5", "N3620A6"), "PARAM.TXT: N3620: axis 6 is not a rotary axis of this machine");
}

TEST_F(FanucSet, BacklashGivesNegativeTravelPointsOfItsOwnAndAsksForThem) {
  for (const ProfileItem& item : controller.questions.items)
    if (!item.of_reversal) machine.profile[item.key] = std::string("confirmed");
  EXPECT_TRUE(make_tables(controller, machine, model, {}).verification.load_ready())
      << "no reversal, no question of it";
  compensation_test::add_effect(model, machine, "backlash:C", "reversal", 60, "urad");
  compensation_test::add_effect(model, machine, "backlash:A", "reversal", -45, "urad");
  const TableSet set = make_tables(controller, machine, model, {});
  EXPECT_EQ(set.verification.unconfirmed, (std::vector<std::string>{"pitch_reverse", "pitch_reference"}));
  for (const char* said : {"N3626A4", "N3627A4", "N3626A5", "N3627A5", "N10250P", "N10700P"})
    EXPECT_THAT(set.files[0].text, ::testing::HasSubstr(said));
  // On each axis alone the two senses differ by the reversal, to a unit of 3623.
  const auto played = play_tables(set.files, machine, model);
  Situation up, down;
  up.at = down.at = {Angle::degrees(-40), Angle::degrees(200)};
  down.tilt_sense = down.turn_sense = -1;
  const double unit = 1e-4 * kDegree_rad;
  EXPECT_NEAR(played->at(down).turn_rad - played->at(up).turn_rad, -60e-6, 2 * unit);
  EXPECT_NEAR(played->at(down).tilt_rad - played->at(up).tilt_rad, 45e-6, 2 * unit);
}

/// What a parameter file makes of its increments: detection units to be added at the points of one axis, positive
/// travel first, negative travel behind it if there is any.
std::vector<std::vector<double>> totals_of(const std::vector<fanuc::Entry>& entries, long axis, bool counts_reference) {
  std::map<long, double> parameters, points;
  for (const fanuc::Entry& e : entries) {
    if (e.axis == axis) parameters[e.number] = e.value;
    if (e.number >= fanuc::kPitchBase && e.number < 19000) points[e.number - fanuc::kPitchBase] = e.value;
  }
  const double magnification = parameters.at(3623);
  const long count = std::lround(parameters.at(3622) - parameters.at(3621)),
             zero = std::lround(parameters.at(3620) - parameters.at(3621));
  std::vector<std::vector<double>> ways;
  for (const long start : {3621L, 3626L}) {
    if (!parameters.contains(start)) continue;
    const long lowest = std::lround(parameters.at(start));
    std::vector<double> totals = {0};
    for (long k = 1; k <= count; ++k) totals.push_back(totals.back() + points.at(lowest + k));
    const double at_zero = totals[static_cast<std::size_t>(zero)];
    for (double& total : totals) total = magnification * (total - at_zero);
    if (start == 3626)
      for (double& total : totals) total += parameters.at(3627) * (counts_reference ? 1 : magnification);
    if (parameters.contains(3625)) {
      EXPECT_NEAR(totals.front(), totals.back(), 1e-6) << "a turn adds up to nothing";
      EXPECT_NEAR(points.at(lowest), points.at(lowest + count), 1e-6) << "the same place";
    }
    ways.push_back(std::move(totals));
  }
  return ways;
}

TEST_F(FanucSet, TotalsStayWithinHalfAnIncrementOfWhatWasMeantAndATurnCloses) {
  constexpr double kBinary = 1e-6;  // of a detection unit
  int compared = 0;
  for (std::uint64_t seed = 60; seed < 66; ++seed)
    for (const char* reference : {"in units of 3623", "in detection units"})
      for (const double spacing : {30.0, 10.0, 3.0}) {
        machine.profile["pitch_reference"] = std::string(reference);
        machine.profile["detection_unit_deg"] = seed % 2 == 0 ? 1e-4 : 1e-5;
        Model random = compensation_test::random_model(machine, seed);
        // Half a unit at the reference among them: it must not be counted twice.
        compensation_test::add_effect(random, machine, "backlash:C", "reversal", seed % 3 == 0 ? 24 : -4.36332313,
                                      "urad");
        compensation_test::add_effect(random, machine, "backlash:A", "reversal", -17, "urad");
        const CompensationTask task(machine, random, {}, controller.questions);
        const auto rounded = fanuc::read_parameters(controller.emit(task, Angle::degrees(spacing), {1, true})[0]),
                   full = fanuc::read_parameters(controller.emit(task, Angle::degrees(spacing), {1, false})[0]);
        for (const long axis : {4L, 5L}) {
          const bool counts = reference == std::string("in detection units");
          const auto found = totals_of(rounded, axis, counts), meant = totals_of(full, axis, counts);
          double half = 0;
          for (const fanuc::Entry& e : rounded)
            if (e.number == 3623 && e.axis == axis) half = 0.5 * e.value;
          ASSERT_EQ(found.size(), 2U);
          ASSERT_EQ(meant.size(), 2U);
          for (std::size_t way = 0; way < 2; ++way)
            for (std::size_t k = 0; k < found[way].size(); ++k, ++compared)
              ASSERT_NEAR(found[way][k], meant[way][k], half + kBinary)
                  << "seed " << seed << " axis " << axis << " " << k;
        }
      }
  EXPECT_GT(compared, 2500);
}

}  // namespace
}  // namespace trunnion
