#include "postproc/playback.h"

#include <gmock/gmock.h>

#include "shop.h"

namespace trunnion {
namespace {

PlaybackResult played(Shop& shop, const std::string& program, const std::string& corrected) {
  const Corrector corrector(shop.chain, shop.field, shop.settings);
  return play_back(opened(program), opened(corrected), corrector, shop.how, shop.result);
}

constexpr double kSecondOrder_mm = 1e-6;  // the error is looked up at the tip, not where the point was meant
constexpr double kSecondOrder_rad = 1e-8;

const char* const kProgram =
    "%\nG21 G0 X10 Y20 Z30 A-40 C50\nG1 X11 Y19.5 A-41 F500\nX40 A-60 C190\nG3 X30 Y29.5 I-10\nG1 G20 X1. Y1.\nG92 "
    "X0\nG91 X.1\n"
    "G90 X1\nG92.1\nT1 M6\nG21 G0 X0 Y0 Z50 A-20 C0\nG1 C40 F300\nG53 G0 Z0\nM30\n%\n";

TEST(Playback, ShowsTheErrorBeforeAndWhatIsLeft) {
  for (const bool tcp : {true, false}) {
    Shop shop;
    shop.how.scan.tcp = tcp;
    shop.how.keep_insertions = true;
    shop.how.scan.work_offsets_mm = {{"G54", {3, -4, 5}}};
    const std::string corrected = shop.correct(kProgram);
    const PlaybackResult result = played(shop, kProgram, corrected);
    EXPECT_EQ(result.moves, 9u);
    EXPECT_GT(result.before.largest_tip_mm, 0.01);
    EXPECT_GT(result.before.largest_tilt_rad, 20e-6);
    EXPECT_LT(result.after.largest_tip_mm, 3e-4);
    EXPECT_LT(result.after.largest_tilt_rad, 8e-6);
    EXPECT_LE(result.after.rms_tip_mm, result.after.largest_tip_mm);
    double before = 0, after = 0;
    for (const PathStretch& stretch : result.along.stretches()) {
      before = std::max(before, stretch.tip_before_mm);
      after = std::max(after, stretch.tip_after_mm);
    }
    EXPECT_EQ(before, result.before.largest_tip_mm);
    EXPECT_EQ(after, result.after.largest_tip_mm);
    EXPECT_EQ(result.along.stretches().size(), result.moves);
  }
}

TEST(Playback, KnowsTheSenseInWhichARotaryAxisCame) {
  Shop shop;
  shop.field.turn_reversal_rad = 60e-6;
  shop.how.keep_insertions = true;
  // It turns about at rapid: within a cutting move no words could follow the step.
  const std::string program = "G21 G0 X100 Y20 Z30 A-40 C50\nC20\nG1 A-50 F500\nC10\nG0 C40\nG1 X90 F300\nC45 A-30\n";
  const PlaybackResult result = played(shop, program, shop.correct(program));
  EXPECT_LT(result.after.largest_tip_mm, 3e-4);
  EXPECT_LT(result.after.largest_tilt_rad, 8e-6);
}

TEST(Playback, TellsWhatTheVirtualMachineTells) {
  for (const char* structure : {"w C' A' Y' b X Z t", "w C' b X Y Z A t", "w b X Y Z C A t"})
    for (const bool tcp : {true, false}) {
      Shop shop(structure);
      shop.how.scan.tcp = tcp;
      shop.how.keep_insertions = true;
      shop.settings.tool_length_mm = 70;
      const std::string program = "G21 G0 X10 Y20 Z30 A-40 C50\n";
      const std::string out = shop.correct(program);
      const PlaybackResult result = played(shop, program, out);
      const auto wanted = testing::play_rs274(program, {}), sent = testing::play_rs274(out, {});
      const Miss before = shop.missed(wanted[0], wanted[0]), after = shop.missed(wanted[0], sent[0]);
      EXPECT_NEAR(result.before.largest_tip_mm, before.tip_mm, kSecondOrder_mm);
      EXPECT_NEAR(result.before.largest_tilt_rad, before.axis_rad, kSecondOrder_rad);
      EXPECT_NEAR(result.after.largest_tip_mm, after.tip_mm, kSecondOrder_mm);
      EXPECT_NEAR(result.after.largest_tilt_rad, after.axis_rad, kSecondOrder_rad);
      EXPECT_GT(before.tip_mm, 0.005);
    }
}

const LimitUse& limit_named(const PlaybackResult& result, const std::string& name) {
  for (const LimitUse& use : result.limits)
    if (use.limit == name) return use;
  throw std::runtime_error(name);
}

/// Behind a refused move the play goes on where all axes are known again; behind a lasting refusal all is a copy.
TEST(Playback, PassesOverWhatWasRefused) {
  Shop shop;
  shop.how.scan.keep_going = true;
  shop.how.keep_insertions = true;
  const std::string program =
      "G21 G90 G0 X10 Y20 Z30 A-40 C50\nG1 X11 F500\nG81 X12 Z5 R6\nG0 X12\nX10 Y20 Z30 A-40 C50\nG1 X12 F500\n"
      "G68 R30\nG1 X14 A-45\nM2\n";
  std::string corrected = shop.correct(program);
  ASSERT_EQ(shop.result.refusals.size(), 2u);
  const PlaybackResult result = played(shop, program, corrected);
  EXPECT_EQ(result.refused, 2u);
  EXPECT_EQ(result.copied_from, 7u);
  EXPECT_EQ(result.moves, 4u);
  EXPECT_GT(result.before.largest_tip_mm, 0.01);
  EXPECT_LT(result.after.largest_tip_mm, 3e-4);
  corrected.replace(corrected.find("X14"), 3, "X15");
  EXPECT_THROW(played(shop, program, corrected), InputError);
}

/// A block beyond a stroke is copied: the machine stands uncorrected there, and the next is judged by its end.
TEST(Playback, PassesOverWhatWasOutOfRange) {
  Shop shop;
  shop.how.scan.keep_going = true;
  shop.how.keep_insertions = true;
  shop.how.guard.stroke[0] = {-100, 60};
  shop.how.scan.tcp = false;
  const std::string program = "G21 G90 G0 X10 Y20 Z30 A-40 C50\nG1 X59.5 F500\nX60.1\nX40\nM2\n";
  const PlaybackResult result = played(shop, program, shop.correct(program));
  ASSERT_EQ(shop.result.refusals.size(), 1u);
  EXPECT_EQ(result.refused, 1u);
  EXPECT_EQ(result.copied_from, 0u);
  EXPECT_LT(result.after.largest_tip_mm, 3e-4);
}

TEST(Playback, TellsHowMuchOfEveryLimitIsUsed) {
  Shop shop;
  shop.how.keep_insertions = true;
  shop.how.scan.tcp = false;
  shop.how.guard.stroke[0] = {-100, 60};
  const std::string program = "G21 G90 G0 X10 Y20 Z30 A-40 C50\nG1 X50 F500\nA-60 C55\nX-20\nM2\n";
  const PlaybackResult result = played(shop, program, shop.correct(program));
  const LimitUse &x = limit_named(result, "axis.X.range_mm"), &probed = limit_named(result, "probed A");
  EXPECT_NEAR(*x.low, -20, 0.2);
  EXPECT_NEAR(x.high, 50, 0.2);
  EXPECT_EQ(x.low_line, 4u);
  EXPECT_EQ(x.allowed_high, 60);
  EXPECT_NEAR(*probed.low, -60, 1e-9);
  EXPECT_NEAR(probed.high, -40, 1e-9);
  EXPECT_NEAR(*probed.allowed_low, -120, 1e-9);
  // The same as the corrector found, by another way.
  const CorrectionCounts& counts = shop.result.counts;
  EXPECT_NEAR(limit_named(result, "limits.correction_um").high, 1e3 * counts.largest_deviation_mm, 0.01);
  EXPECT_NEAR(limit_named(result, "limits.correction_urad").high, 1e6 * counts.largest_tilt_rad, 0.1);
  // The corrector's largest change is of pieces, the limit's of whole blocks.
  EXPECT_GT(limit_named(result, "limits.change_um").high, 1e3 * counts.largest_position_change_mm - 0.2);
}

TEST(Playback, KnowsTheSensesOfTheSlides) {
  Shop shop;
  shop.field.slide_reversal_mm = 0.004;
  shop.how.scan.chain = &shop.chain;
  shop.how.scan.follow_senses = true;
  shop.how.keep_insertions = true;
  // They turn about at rapid; under tool-centre-point control C moves all of them.
  const std::string program = "G21 G0 X100 Y20 Z30 A-40 C50\nC20\nX90\nG1 X80 F300\nG0 C60 X85\nZ40 A-20\n";
  const PlaybackResult result = played(shop, program, shop.correct(program));
  EXPECT_LT(result.after.largest_tip_mm, 3e-4);
}

TEST(Playback, SeesAWordThatIsWrong) {
  Shop shop;
  shop.how.keep_insertions = true;
  std::string corrected = shop.correct(kProgram);
  const std::size_t line = corrected.find("G1 X1");
  corrected.replace(line, 5, "G1 X2");
  const PlaybackResult result = played(shop, kProgram, corrected);
  EXPECT_NEAR(result.after.largest_tip_mm, 10, 0.01);
  EXPECT_EQ(result.after.tip_line, 3u);
}

TEST(Playback, WantsProgramsThatBelongTogether) {
  Shop shop;
  shop.how.keep_insertions = true;
  const std::string corrected = shop.correct(kProgram);
  EXPECT_THROW(played(shop, kProgram, corrected.substr(0, 300)), InputError);
  EXPECT_THROW(played(shop, kProgram, corrected + "X1\n"), InputError);
}

}  // namespace
}  // namespace trunnion
