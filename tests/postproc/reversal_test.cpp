#include <gmock/gmock.h>

#include "postproc/playback.h"
#include "shop.h"

// What an axis loses where it turns round is taken up in a block of its own.

namespace trunnion {
namespace {

constexpr double kLost_rad = 60e-6;

/// To and fro in short blocks, C turning round twice; the first block sets out in the positive sense.
std::string to_and_fro(const std::string& head, const std::string& line, const std::string& tail) {
  std::string text = head;
  const auto move = [&](int k) {
    char words[160];
    std::snprintf(words, sizeof words, line.c_str(), 60 + 0.1 * k, 20 - 0.05 * k, 0.2 * k);
    text += words;
  };
  for (int k = 1; k <= 10; ++k) move(k);
  for (int k = 9; k >= 0; --k) move(k);
  for (int k = 1; k <= 5; ++k) move(k);
  return text + tail;
}

PathError left_of(Shop& shop, const std::string& program, const std::string& corrected) {
  const Corrector corrector(shop.chain, shop.field, shop.settings);
  return play_back(opened(program), opened(corrected), corrector, shop.how, shop.result).after;
}

struct ReversingProgram {
  const char *head, *line;
};
constexpr ReversingProgram kPerMinute{"G21 G90 G94\nG0 X60 Y20 Z40 A-30 C0\nF500\n", "G1 X%.4f Y%.4f C%.4f\n"};
constexpr ReversingProgram kPerBlock{"G21 G90 G93\nG0 X60 Y20 Z40 A-30 C0\n", "G1 X%.4f Y%.4f C%.4f F300\n"};

TEST(Reversal, IsTakenUpInABlockOfItsOwnBeforeTheAxisGoesOn) {
  for (const ReversingProgram& p : {kPerMinute, kPerBlock})
    for (const bool tcp : {true, false}) {
      Shop shop("w C' A' Y' b X Z t", 0.1);
      shop.field.turn_reversal_rad = kLost_rad;
      shop.how.scan.tcp = tcp;
      shop.how.keep_insertions = true;
      const std::string program = to_and_fro(p.head, p.line, "M2\n"), corrected = shop.correct(program);
      SCOPED_TRACE(std::string(tcp ? "tcp\n" : "\n") + corrected.substr(0, 1500));
      ASSERT_EQ(shop.result.inserted.size(), 2U);
      for (const Insertion& insertion : shop.result.inserted) EXPECT_TRUE(insertion.takes_up && insertion.count == 1);
      const PathError left = left_of(shop, program, corrected);
      EXPECT_LT(left.largest_tip_mm, 0.5e-3);  // of 4 um that the play is worth there; words of four decimals
      EXPECT_LT(left.largest_tilt_rad, 5e-6);
    }
}

/// A time per block: a line more must not cost the others theirs.
TEST(Reversal, KeepsTheDurationOfTheWay) {
  Shop shop("w C' A' Y' b X Z t", 0.1);
  shop.field.turn_reversal_rad = kLost_rad;
  const std::string corrected = shop.correct(to_and_fro(kPerBlock.head, kPerBlock.line, "M2\n"));
  std::size_t with_feed = 0;
  for (std::size_t at = corrected.find(" F300"); at != std::string::npos; at = corrected.find(" F300", at + 1))
    ++with_feed;
  EXPECT_EQ(with_feed, 27U) << corrected;  // 25 moves and two that take up
}

/// An arc at whose begin an axis turns round becomes lines, the first of which takes up.
TEST(Reversal, IsTakenUpBeforeAnArc) {
  Shop shop("w C' A' Y' b X Z t", 0.1);
  shop.field.turn_reversal_rad = kLost_rad;
  shop.how.keep_insertions = true;
  const std::string program =
      "G21 G90 G94\nG0 X60 Y20 Z40 A-30 C0\nF500\nG1 C0.5\nG3 X59.9 Y20.1 I-0.1 C0.4\nG1 C0.3\nM2\n";
  const std::string corrected = shop.correct(program);
  SCOPED_TRACE(corrected);
  ASSERT_EQ(shop.result.inserted.size(), 1U);
  EXPECT_TRUE(shop.result.inserted[0].takes_up);
  EXPECT_EQ(shop.result.inserted[0].line, 5U);
  EXPECT_EQ(shop.result.counts.reversals_left, 0U);
  EXPECT_LT(left_of(shop, program, corrected).largest_tip_mm, 0.5e-3);
}

/// X and Y turn round on a full circle: nothing is taken up on the way, and what that leaves is told.
TEST(Reversal, InsideAnArcIsCounted) {
  Shop shop("w C' A' Y' b X Z t", 0.1);
  shop.field.slide_reversal_mm = 0.003;
  shop.how.scan.tcp = false;
  shop.how.scan.follow_senses = true;
  shop.how.scan.chain = &shop.chain;
  shop.correct("G21 G90 G94\nG0 X60 Y20 Z40 A-30 C0\nF500\nG1 X61\nG3 X61 Y20 I-10\nM2\n");
  const CorrectionCounts& counts = shop.result.counts;
  EXPECT_EQ(counts.reversals_left, 1U);
  EXPECT_EQ(counts.largest_reversal_left_line, 5U);
  EXPECT_NEAR(counts.largest_reversal_left_mm, 0.003 * std::sqrt(2.0), 2e-4);
  shop.correct("G21 G90 G94\nG0 X60 Y20 Z40 A-30 C0\nF500\nG1 X61\nX62\nM2\n");
  EXPECT_EQ(shop.result.counts.reversals_left, 0U);
}

/// Before a block that cannot be divided there is no place for a block more.
TEST(Reversal, BeforeABlockThatCannotBeDividedIsCounted) {
  Shop shop("w C' A' Y' b X Z t", 0.1);
  shop.field.turn_reversal_rad = kLost_rad;
  shop.correct("G21 G90 G94\nG0 X60 Y20 Z40 A-30 C0\nF500\nG1 C0.5\nG1 X59.5 C0.4 M0\nM2\n");
  EXPECT_EQ(shop.result.counts.reversals_left, 1U);
  EXPECT_EQ(shop.result.counts.largest_reversal_left_line, 5U);
  EXPECT_GT(shop.result.counts.largest_reversal_left_mm, 1e-3);
}

TEST(Duration, OfMovesThatTellNoneIsCounted) {
  Shop shop("w C' A' Y' b X Z t", 0.1);
  shop.field.drift_mm_per_s = 1e-5;
  shop.how.scan.follow_time = true;
  shop.correct("G21 G90 G94\nG0 X60 Y20 Z40 A-30 C0\nG1 X61 F500\nG0 X62\nG95 G1 X63 F0.1\nG94 X64 F500\nM2\n");
  EXPECT_EQ(shop.result.counts.untimed_moves, 3U);
  EXPECT_EQ(shop.result.counts.first_untimed_line, 2U);
}

}  // namespace
}  // namespace trunnion
