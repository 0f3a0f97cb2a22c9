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
