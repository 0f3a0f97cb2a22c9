#include "testpiece/piece_program.h"

#include <gmock/gmock.h>

#include "postproc/playback.h"
#include "testpiece/pieces.h"

namespace trunnion {
namespace {

TEST(PieceProgram, BringsTheToolWhereThePathHasIt) {
  constexpr double kWritten_mm = 0.51e-5, kWritten_deg = 0.51e-6;  // decimals of the words
  const TestPiece piece = usual_piece(15, 10);
  const std::vector<ToolPosition> path =
      flank_milling_path(piece, KinematicChain(trunnion_machine()), {.steps_per_turn = 720});
  const std::string text = piece_program(piece, path, 'A');
  const OpenProgram open = [&] {
    return [&, at = std::size_t{0}](char* buffer, std::size_t size) mutable {
      const std::size_t taken = text.copy(buffer, size, at);
      at += taken;
      return taken;
    };
  };
  const std::vector<PlayedPlace> places = played_places(open, {}, 1e3, 1e3);
  ASSERT_EQ(places.size(), path.size() + 1);  // the way out follows
  for (std::size_t i = 0; i < path.size(); ++i) {
    for (Eigen::Index k = 0; k < 3; ++k)
      EXPECT_NEAR(places[i].at[static_cast<std::size_t>(k)], path[i].nominal.tip_w_mm[k], kWritten_mm);
    EXPECT_NEAR(places[i].at[kTilt], path[i].at.a.in_degrees(), kWritten_deg);
    EXPECT_NEAR(places[i].at[kTurn], path[i].at.c.in_degrees(), kWritten_deg);
  }
  EXPECT_THAT(text, ::testing::HasSubstr("\nM2\n"));
  EXPECT_THAT(text, ::testing::Not(::testing::HasSubstr("-0.00000 ")));
  // Finer steps pass through the same places.
  const std::vector<PlayedPlace> fine = played_places(open, {}, 0.1, 0.1);
  EXPECT_GT(fine.size(), 3 * places.size());
  EXPECT_EQ(fine.back().at, places.back().at);
}

TEST(PieceProgram, StartsAndEndsClearOfThePiece) {
  TestPiece piece = usual_piece(15, 30);
  piece.feed_mm_per_min = 450;
  const auto path = flank_milling_path(piece, KinematicChain(trunnion_machine()), {.steps_per_turn = 360});
  const std::string text = piece_program(piece, path, 'A');
  EXPECT_THAT(text, ::testing::HasSubstr("\nG0 X"));
  EXPECT_THAT(text, ::testing::HasSubstr(" F450.0\n"));
}

}  // namespace
}  // namespace trunnion
