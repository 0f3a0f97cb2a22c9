#include "postproc/program_correction.h"

#include <gmock/gmock.h>

#include <cstring>
#include <random>

#include "shop.h"

namespace trunnion {
namespace {

using ::testing::HasSubstr;

constexpr double kTip_mm = 2e-4;    // 0.2 um, what four decimals leave room for
constexpr double kAxis_rad = 8e-6;  // beyond 5 deg of tilt

std::string without_header(const std::string& text) {
  const std::size_t mark = text.find(kCorrectedMark);
  if (mark == std::string::npos) return text;
  const std::size_t begin = text.rfind('(', mark), end = text.find('\n', mark) + 1;
  return text.substr(0, begin) + text.substr(end);
}

/// A finishing path on a sphere: every line but the first moves all five axes, with the style of a CAM system.
std::string sphere(int lines, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::string text = "%\n(SPHERE)\nG21 G90 G94\nT1 M6\nS8000 M3\nG0 X0. Y0. Z80. A-10. C0.\n";
  char line[160];
  for (int i = 0; i < lines; ++i) {
    const double c = i * 1.3, a = -10 - 70.0 * i / lines;
    std::snprintf(line, sizeof line, "N%d G1 X%.3f Y%.3f Z%.4f A%.3f C%.4f", 10 * (i + 1), 40 * std::cos(c / 57),
                  40 * std::sin(c / 57), 80 - 0.01 * i, a, c);
    text += line;
    text += random() % 5 == 0 ? " F1500.\n" : "\n";
  }
  return text + "M5\nM30\n%\n";
}

TEST(ProgramCorrection, BringsEveryEndPointToItsPlace) {
  for (const bool tcp : {true, false})
    for (const char* structure : {"w C' A' Y' b X Z t", "w C' B' X' b Y Z t"}) {
      Shop shop(structure);
      shop.how.scan.tcp = tcp;
      std::string program = sphere(500);
      if (structure[5] == 'B')
        for (char& c : program)
          if (c == 'A') c = 'B';
      const std::string out = shop.correct(program);
      const auto wanted = testing::play_rs274(program, {}, shop.both.machine.tilt_letter());
      const auto sent = testing::play_rs274(out, {}, shop.both.machine.tilt_letter());
      ASSERT_EQ(wanted.size(), sent.size());
      double before = 0;
      for (std::size_t i = 0; i < wanted.size(); ++i) {
        const Miss left = shop.missed(wanted[i], sent[i]);
        EXPECT_LT(left.tip_mm, kTip_mm) << i;
        EXPECT_LT(left.axis_rad, kAxis_rad) << i;
        before = std::max(before, shop.missed(wanted[i], wanted[i]).tip_mm);
      }
      EXPECT_GT(before, 0.02);
      EXPECT_EQ(shop.result.counts.corrected_blocks, 501u);
    }
}

TEST(ProgramCorrection, ChangesNoByteWithoutErrors) {
  Shop shop("w C' A' Y' b X Z t", 0);
  const std::string programs[] = {
      sphere(3000),
      "",
      "\n",
      "%",
      "g0x1y2z3a-4c5\ng1 x 1 . 5 f100\n",
      "G20\r\nG0 X1 Y2 Z3 A-4 C5\r\nG91\r\nG1 X.1 F10\r\nG92 X0\r\nM2",
      "G0X1Y2Z3A-4C5\n\r\rG1X+1.500F20.\n\r\rM30\n\r\r",
      "\xef\xbb\xbf(\xc3\xa4 comment)\nG0 X1 Y2 Z3 A-4 C5 ; caf\xe9\nG1 C400 F100\nM2\nwhatever follows ?? X#1\n",
      "G0 G54 X1.00001 Y2 Z3 A-4 C5\nG55 G1 X1.5 F100\nG91 X.33333\nG1 C90\nX100\n"};
  for (const bool tcp : {true, false})
    for (const std::string& program : programs) {
      shop.how.scan.tcp = tcp;
      shop.how.scan.work_offsets_mm = {{"G54", {1.0 / 3, 2e-5, -7}}, {"G55", {5.00001, 1e-7, 0}}};
      EXPECT_EQ(shop.correct(program), program);
      EXPECT_FALSE(shop.result.counts.changed());
    }
}

/// A line of plain numbers is read without tokens; a comment behind it makes it one that is not.
TEST(ProgramCorrection, ReadsPlainLinesAsItReadsAllOthers) {
  const std::string head = "G21 G90 G94\nG0 X1 Y2 Z3 A-40 C5\n";
  for (const char* line :
       {"N10 G1 X10.5 Y-3.25 Z40. A-41.5 C12.125 F1200", "n20g01x11y-3z.5a-42.c13", "X+7.5\tY0.0", " G0 X 8.",
        "C 361.25", "F300.5", "G1", "N7", "X-0.0001 F10", "X00012.50Y-.5", "Z5 X4", "X1 2.5", "G91 X.5", "\t"}) {
    Shop plain, told;
    const std::string end = "\nG90 G1 X20. Y3. Z41. A-39. C11. F900\n";
    std::string sent = plain.correct(head + line + end), other = told.correct(head + line + " (told)" + end);
    const std::size_t comment = other.find(" (told)");
    ASSERT_NE(comment, std::string::npos) << line;
    // A word that is added stands before the comment.
    EXPECT_EQ(other.erase(comment, 7), sent) << line;
    EXPECT_EQ(plain.result.counts.corrected_blocks, told.result.counts.corrected_blocks) << line;
  }
  for (const char* line : {"X1 X2", "X1.5.2", "X1000001", "F-1", "F1 F2", "G1 X", "X1234567890123456789", "G2"}) {
    Shop plain, told;
    EXPECT_EQ(plain.refusal(head + line), told.refusal(head + line + " (told)")) << line;
  }
}

TEST(ProgramCorrection, DoesNotDependOnChunksOrThreads) {
  Shop shop;
  std::string program = sphere(2000);
  program.replace(program.find("N5000 "), 6, "G91 ");
  program.replace(program.find("N5010 "), 6, "G90 ");
  // X alone, C alone, inch, G92, unknown again.
  program.insert(program.find("N8000 "),
                 "X10.5\nC500. F300\nG20\nX1. Y2.\nG92 X0\nG1 X.1 F20\nG92.1 G21\nG53 G0 Z0\nX1\nZ50\n");
  const std::string whole = shop.correct(program);
  for (const std::size_t chunk : {16u, 100u, 1000u, 5000u})
    for (const int threads : {1, 2, 5}) {
      shop.how.chunk_bytes = chunk;
      shop.how.threads = threads;
      EXPECT_EQ(shop.correct(program), whole) << chunk << " " << threads;
    }
}

TEST(ProgramCorrection, TouchesNothingButWordsThatMove) {
  Shop shop;
  const std::string out = shop.correct(
      "%\r\n(name)\r\nG21\r\nG0 X10.0 Y20. Z+30 A-.5 C007.5 (first)\r\n"
      "n20 g1x11y 2 1 f1000 ; second\r\nM8\r\n  A-45\r\nM2\r\nX#5\r\n");
  EXPECT_EQ(
      out,
      "%\r\n(corrected by trunnion: model 1a2b, machine Trunnion, serial 7)\r\n(name)\r\nG21\r\n"
      "G0 X9.9982 Y19.9986 Z+29.9998 A-.5002 C007.5013 (first)\r\nn20 g1x10.9982y 20.9986 f1000 ; second\r\nM8\r\n"
      "  G93 A-9.3999 X10.9974 Y20.9984 Z+29.997 C007.5014 F112.3596\r\n"
      "X10.9967 Y20.999 Z+29.9945 A-18.2996 C007.5015 F112.3596\r\n"
      "X10.9962 Y21.0004 Z+29.9927 A-27.1993 C007.5017 F112.3596\r\n"
      "X10.9958 Y21.0025 Z+29.9918 A-36.0991 C007.5019 F112.3596\r\n"
      "X10.9954 Y21.0049 Z+29.9919 A-44.9988 C007.5021 F112.3596\r\n"
      "G94 F1000\r\nM2\r\nX#5\r\n");
}

TEST(ProgramCorrection, AddsTheAxesThatAMoveNeeds) {
  Shop shop;
  shop.settings.orientation = Orientation::as_programmed;
  const std::string program = "G0 X10 Y20 Z30 A-30 C60\nX50\nX50.\nG1X60F100\n";
  const std::string out = without_header(shop.correct(program));
  const auto wanted = testing::play_rs274(program, {}), sent = testing::play_rs274(out, {});
  ASSERT_EQ(wanted.size(), sent.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) EXPECT_LT(shop.missed(wanted[i], sent[i]).tip_mm, kTip_mm);
  EXPECT_EQ(out,
            "G0 X9.9844 Y20.0024 Z29.9865 A-30 C60\nX49.9844 Y20.0023 Z29.9876\nX49.9844\n"
            "G1X59.9844Y20.0022Z29.9878F100\n");
}

TEST(ProgramCorrection, CopiesAndCountsWhatComesBeforeAllAxesAreKnown) {
  Shop shop;
  const std::string head = "G0 Z100\nA-30 C20\nX5\n";
  const std::string out = without_header(shop.correct(head + "Y5\nG53 G0 Z0\nX7\nX8\nZ10\nT2 M6\nZ50\nG28 Z0\nM2\n"));
  EXPECT_TRUE(out.starts_with(head)) << out;
  EXPECT_EQ(shop.result.counts.copied_moves, 3u + 3u + 2u);
  EXPECT_EQ(shop.result.counts.corrected_blocks, 2u);
  EXPECT_THAT(out, HasSubstr("G53 G0 Z0\nX7\nX8\nZ9.99"));
}

TEST(ProgramCorrection, FollowsInchIncrementsShiftsAndOffsets) {
  Shop shop;
  shop.how.scan.work_offsets_mm = {{"G54", {10, -20, 5}}};
  const std::string program =
      "G21 G90\nG0 X10 Y20 Z30 A-30 C60\nG91\nG1 X5. Y1. F500\nX5. A-2.\nX-.5 Y.25 Z1. C3\nG20\nX.1\nY-.1 C1\nG90\nX1. "
      "Y1.\n"
      "G92 X0 Y0\nG1 X.5 Y.25 A-33\nG21\nX1 Y1\nG91 X1\nG92.1\nG90 X3\n";
  for (const bool tcp : {true, false}) {
    shop.how.scan.tcp = tcp;
    const std::string out = shop.correct(program);
    const auto wanted = testing::play_rs274(program.substr(0, program.find("G92.1")), {10, -20, 5});
    const auto sent = testing::play_rs274(out.substr(0, out.find("G92.1")), {10, -20, 5});
    ASSERT_EQ(wanted.size(), sent.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const Miss left = shop.missed(wanted[i], sent[i]);
      EXPECT_LT(left.tip_mm, kTip_mm) << i << "\n" << out;
      EXPECT_LT(left.axis_rad, kAxis_rad) << i;
    }
  }
}

TEST(ProgramCorrection, DividesLongMovesUntilTheyHoldBetween) {
  for (const bool tcp : {true, false})
    for (const char* feed : {"G94 G1 F800", "G93 G1 F4", "G91 G1 F500"}) {
      Shop shop;
      shop.how.scan.tcp = tcp;
      const bool incremental = std::strstr(feed, "G91") != nullptr;
      const std::string program = std::string("G0 X10 Y20 Z30 A-10 C0\n") + feed +
                                  (incremental ? " X30 Y-50. A-50 C190" : " X40 Y-30. A-60 C190") +
                                  "\nG90 G94 X41 F100\n";
      const std::string out = shop.correct(program);
      const auto wanted = testing::play_rs274(program, {}), sent = testing::play_rs274(out, {});
      ASSERT_EQ(wanted.size(), 3u);
      ASSERT_GT(sent.size(), 8u);
      const std::size_t n = sent.size() - 2;
      EXPECT_EQ(shop.result.counts.inserted_blocks, n - 1);
      double minutes = 0;
      for (std::size_t k = 1; k <= n; ++k) {
        minutes += sent[k].minutes;
        for (const double s : {0.1, 0.25, 0.4, 0.5, 0.7, 0.9, 1.0}) {
          testing::PlayedMove at, meant;
          for (std::size_t i = 0; i < 5; ++i) {
            at.at[i] = sent[k - 1].at[i] + s * (sent[k].at[i] - sent[k - 1].at[i]);
            const double whole = (static_cast<double>(k - 1) + s) / static_cast<double>(n);
            meant.at[i] = wanted[0].at[i] + whole * (wanted[1].at[i] - wanted[0].at[i]);
          }
          const Miss left = shop.missed(meant, at);
          EXPECT_LT(left.tip_mm, kTip_mm + 1e-4) << k << " " << s;  // tolerance and rounding
          EXPECT_LT(left.axis_rad, kAxis_rad) << k << " " << s;
        }
      }
      EXPECT_NEAR(minutes, wanted[1].minutes, 0.005 * wanted[1].minutes) << out;
    }
}

TEST(ProgramCorrection, KeepsTheDurationOfATurn) {
  Shop shop;
  const std::string program = "G0 X10 Y20 Z30 A-40 C0\nG1 C1.5 F300\nX11\nG1 C90 F300\nG20\nA-41\n";
  const std::string out = shop.correct(program);
  const auto wanted = testing::play_rs274(program, {}), sent = testing::play_rs274(out, {});
  double minutes = 0, meant = 0;
  for (const auto& move : wanted) meant += move.minutes;
  for (const auto& move : sent) minutes += move.minutes;
  EXPECT_NEAR(minutes, meant, 0.001 * meant) << out;
  EXPECT_THAT(out, HasSubstr("G93"));
  EXPECT_THAT(out, HasSubstr("G94 F300"));
}

TEST(ProgramCorrection, TakesTheFeedBesideABlendingTolerance) {
  Shop shop;
  const std::string out = shop.correct("G0 X10 Y20 Z30 A-40 C0\nG1 F100\nG64 P0.01 F300\nC90\n");
  EXPECT_THAT(out, HasSubstr("G94 F300"));
}

TEST(ProgramCorrection, FollowsTheSensesOfTheSlides) {
  Shop shop("w C' A' Y' b X Z t", 0);
  shop.field.slide_reversal_mm = 0.004;
  shop.how.scan.chain = &shop.chain;
  shop.how.scan.follow_senses = true;
  // They lag by half of it in the sense of their last motion; a micrometre to and fro is none. C takes the tip to X-6
  // Y15 of the slides: X has gone back, Y forth.
  EXPECT_EQ(without_header(shop.correct("G0 X10 Y5 Z5 A0 C0\nX20\nX20.0005\nX20\nX15 Y6\nC90\n")),
            "G0 X10 Y5 Z5 A0 C0\nX20.002\nX20.0025\nX20.002\nX14.998 Y6.002\nC90 X15.002\n");
}

TEST(ProgramCorrection, CountsTheTimeAtFeed) {
  Shop shop("w C' A' Y' b X Z t", 0);
  shop.field.drift_mm_per_s = 1e-4;
  shop.how.scan.follow_time = true;
  // 1 s along X, none at rapid, 2 s of inverse time, 1 s of an arc of pi mm, 3 s of a turn.
  EXPECT_EQ(without_header(shop.correct("G0 X10 Y5 Z5 A0 C0\nG1 X20 F600\nG0 X0\nG93 G1 X1 F30\nG94 G2 X3 I1 "
                                        "F188.4956\nG1 C1 F20\n")),
            "G0 X10 Y5 Z5 A0 C0\nG1 X20 Z5.0001 F600\nG0 X0\nG93 G1 X1 Z5.0003 F30\nG94 G2 X3 I1 Z5.0004 "
            "F188.4956\nG1 G93 C1 Z5.0007 F20\nG94 F20\n");
}

TEST(ProgramCorrection, RefusesACorrectedProgram) {
  Shop shop;
  const std::string once = shop.correct(sphere(3));
  EXPECT_EQ(shop.refusal(once), "part.ngc:2: this program has been corrected already; correct the original");
  shop.how.scan.keep_going = true;
  EXPECT_EQ(shop.refusal(once), "part.ngc:2: this program has been corrected already; correct the original");
}

TEST(ProgramCorrection, KeepsWithinLimitsAndStrokes) {
  const std::string program = "G0 X10 Y20 Z30 A-40 C0\nG1 X90 A-60 F100\n";
  Shop shop;
  shop.how.guard.stroke[kTilt] = {-50, 30};
  EXPECT_EQ(shop.refusal(program), "part.ngc:2: A would go to -60 deg, its stroke is -50 ... 30");
  shop.how.guard.stroke[kTilt] = {-60, 30};  // its own correction may leave it
  EXPECT_THAT(shop.refusal(program), HasSubstr("corrected by"));
  shop.how.guard.stroke[0] = {-80, 80};
  EXPECT_THAT(shop.refusal(program), HasSubstr("part.ngc:2: X would go to 89.9"));
  shop.how.guard.stroke[0].reset();
  shop.how.guard.limits.deviation = Length::micrometres(1);
  EXPECT_THAT(shop.refusal(program), HasSubstr("um, limits.correction_um is 1"));
  shop.how.guard.limits = {};
  shop.how.guard.limits.tilt = Angle::microradians(2);
  EXPECT_THAT(shop.refusal(program), HasSubstr("urad, limits.correction_urad is 2"));
  shop.how.guard.limits = {};
  EXPECT_EQ(shop.refusal("G0 X1 Y1 Z1 A0 C0\nA-121\n"), "part.ngc:2: A-121: outside the probed range -120 ... 120 deg");
}

/// Where the head tilts the tool, its tip is elsewhere than the slides.
TEST(ProgramCorrection, JudgesStrokesByTheSlidesOfAHead) {
  Shop shop("w C' b X Y Z A t");
  shop.settings.tool_length_mm = 80;
  shop.how.scan.tcp = false;
  shop.how.guard.stroke[1] = {-1, 1};
  const std::string program = "G21 G90 G0 X10 Y0 Z50 A-40 C10\n";
  EXPECT_THAT(shop.refusal(program), ::testing::HasSubstr("corrected by"));
  shop.how.scan.tcp = true;
  EXPECT_THAT(shop.refusal(program), ::testing::HasSubstr("Y would go to"));
}

TEST(ProgramCorrection, RefusesACorrectionThatLeaps) {
  const std::string program = "G0 X10 Y20 Z30 A-40 C0\nG1 X12 A-60 C90 F100\n";
  Shop shop;
  shop.how.guard.change = Length::micrometres(2);
  EXPECT_THAT(shop.refusal(program), HasSubstr("part.ngc:2: the correction changes by "));
  shop.how.guard.change = Length::micrometres(200);
  shop.how.guard.rotary_change = Angle::degrees(1e-4);
  EXPECT_THAT(shop.refusal(program), HasSubstr("deg from the block before, limits.change_deg is 0.0001"));
}

TEST(ProgramCorrection, KeepsGoingWhenAsked) {
  Shop shop;
  shop.how.scan.keep_going = true;
  const std::string program = "G0 X1 Y1 Z1 A-20 C0\nG5 X5 I2\nG1 X6 F10\nX1 Y1 Z1 A-20 C0\nX2\nA-125\nX3 Y3\n A-20\n";
  const std::string out = shop.correct(program);
  ASSERT_EQ(shop.result.refusals.size(), 4u);
  EXPECT_EQ(shop.result.refusals[0].line, 2u);
  EXPECT_EQ(shop.result.refusals[1].line, 6u);
  EXPECT_EQ(shop.result.refusals[2].line, 7u);
  EXPECT_EQ(shop.result.refusals[3].line, 8u);  // it comes from where nothing was measured
  EXPECT_THAT(out, HasSubstr("\nG5 X5 I2\nG1 X6 F10\n"));
  EXPECT_THAT(out, HasSubstr("\nA-125\n"));
}

TEST(ProgramCorrection, KeepsGoingOnlyWhereModesAndZerosAreKnown) {
  const std::string head = "G0 X10 Y10 Z1 A-40 C0\n", move = "X20 Y1 Z2 A-45 C3\n";
  // A move that is refused, and one whose own codes are followed: the next block is corrected.
  for (const char* refused : {"X#1\n", "G1 F100 X#1\n", "M8 G81 X1 Z-5 R2 F100\nG1 F50\n"}) {
    Shop shop;
    shop.how.scan.keep_going = true;
    const std::string out = shop.correct(head + refused + move);
    EXPECT_THAT(out, HasSubstr(refused));
    EXPECT_THAT(out, ::testing::Not(HasSubstr(move))) << refused;
  }
  // Modes or zeros that are not: copied to the end.
  for (const char* refused :
       {"G10 L2 P1 X5\n", "G91 X#1\n", "M98 P1\n", "X#1 G55\n", "/ G20\n", "G20 G41 D1 A-50\nG21 G41 G10 X0\n"}) {
    Shop shop;
    shop.how.scan.keep_going = true;
    const std::string out = shop.correct(head + refused + move + "M30\n");
    EXPECT_TRUE(out.ends_with(refused + move + "M30\n")) << out;
    EXPECT_THAT(shop.result.refusals.back().reason, HasSubstr("; from here on the program is copied"));
  }
}

TEST(ProgramCorrection, CopiesAnArcThatTheLinesBeforeItWouldHaveStraightened) {
  Shop shop;
  shop.how.scan.keep_going = true;
  shop.how.guard.stroke[0] = {-80, 80};
  const std::string out = shop.correct("G17 G0 X10 Y10 Z1 A-40 C0\nG2 X50 Y10 R20 F100\nX90 R20\nX50 R20\n");
  ASSERT_EQ(shop.result.refusals.size(), 2u) << out;
  EXPECT_THAT(out, HasSubstr("\nG2 X90 R20\nX50 R20\n"));
  // One that was not understood cannot be copied behind lines either.
  Shop other;
  other.how.scan.keep_going = true;
  EXPECT_EQ(
      other.refusal("G17 G0 X10 Y10 Z1 A-40 C0\nG2 X50 Y10 R20 F100\nX#1 Y10 R20\n"),
      "part.ngc:3: X is not followed by a plain number; variables and expressions in motion words are not computed");
}

}  // namespace
}  // namespace trunnion
