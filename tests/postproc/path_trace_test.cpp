#include "postproc/path_trace.h"

#include <gmock/gmock.h>

namespace trunnion {
namespace {

PathStretch at_line(std::uint64_t line, double tip_mm) {
  return {.line = line, .tip_before_mm = tip_mm, .tip_after_mm = tip_mm / 10, .tilt_before_rad = tip_mm / 100};
}

TEST(PathTrace, KeepsAShortProgramLineByLine) {
  PathTrace trace(8);
  trace.add(at_line(3, 0.001));
  trace.add(at_line(3, 0.002));
  trace.add(at_line(5, 0.001));
  EXPECT_THAT(trace.stretches(), ::testing::ElementsAre(at_line(3, 0.002), at_line(5, 0.001)));
  EXPECT_EQ(trace.lines_per_stretch(), 1u);
}

TEST(PathTrace, JoinsNeighboursOfALongProgramAndKeepsTheLargest) {
  PathTrace trace(10);
  for (std::uint64_t line = 1; line <= 1000; ++line) trace.add(at_line(line, line == 617 ? 5 : 1));
  EXPECT_LE(trace.stretches().size(), 10u);
  EXPECT_EQ(trace.lines_per_stretch(), 128u);
  double largest = 0;
  for (std::size_t i = 0; i < trace.stretches().size(); ++i) {
    const PathStretch& stretch = trace.stretches()[i];
    if (i > 0) {
      EXPECT_EQ(stretch.line, 128 * i);
    }
    if (stretch.tip_before_mm > largest) {
      largest = stretch.tip_before_mm;
      EXPECT_TRUE(largest == 1 || (stretch.line <= 617 && 617 < stretch.line + 128));
    }
  }
  EXPECT_EQ(largest, 5);
}

}  // namespace
}  // namespace trunnion
