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

}  // namespace
}  // namespace trunnion
