#include "postproc/piece_program.h"

#include <gmock/gmock.h>

#include <map>

#include "postproc/dialect.h"
#include "postproc/playback.h"
#include "shop.h"
#include "testpiece/pieces.h"

namespace trunnion {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// Half of the last decimal that a dialect's words carry.
struct Rounding {
  double mm, deg;
};
const std::map<std::string, Rounding> kRounding = {{"linuxcnc", {0.51e-5, 0.51e-6}},
                                                   {"sinumerik", {0.51e-5, 0.51e-6}},
                                                   {"fanuc", {0.51e-4, 0.51e-4}},
                                                   {"heidenhain", {0.51e-4, 0.51e-4}}};

struct Planned {
  TestPiece piece = usual_piece(15, 10);
  KinematicChain chain{trunnion_machine()};
  std::vector<ToolPosition> path = flank_milling_path(piece, chain, {.steps_per_turn = 720});
};

ScanSettings reading(const Planned& planned, const PieceProgramStyle& style) {
  ScanSettings scan;
  scan.control = style.control;
  scan.modulo_turn = style.modulo_turn;
  scan.chain = &planned.chain;
  scan.tcp = !dialect(style.dialect).says_tcp;
  scan.tcp_forced = scan.tcp;
  scan.tilt_stroke_deg = {-120, 30};
  const Eigen::Vector3d& g54 = style.work_offset_mm;
  scan.work_offsets_mm = {{"G54", {g54.x(), g54.y(), g54.z()}}};
  return scan;
}

TEST(PieceProgram, BringsTheToolWhereThePathHasItInEveryDialect) {
  const Planned planned;
  for (const auto& [name, rounding] : kRounding)
    for (const char* tcp_frame : {"zero", "start", "fixed"})
      for (const bool modulo : {true, false}) {
        const PieceProgramStyle style{name, 'A', {.tcp_frame = tcp_frame}, modulo, {7, -8, 9}};
        const std::string text = piece_program(planned.piece, planned.path, planned.chain, style);
        SCOPED_TRACE(name + ", frame " + tcp_frame + (modulo ? ", modulo" : "") + "\n" + text.substr(0, 700));
        const std::vector<PlayedPlace> places = played_places(opened(text), reading(planned, style), 1e3, 1e3, name);
        ASSERT_EQ(places.size(), planned.path.size() + 1);  // the way out follows
        for (std::size_t i = 0; i < planned.path.size(); ++i) {
          const ToolPosition& meant = planned.path[i];
          EXPECT_EQ(places[i].tcp, name == "linuxcnc" || std::string(tcp_frame) != "fixed");
          const Eigen::Vector3d& tip = places[i].tcp ? meant.nominal.tip_w_mm : meant.tip_r_mm;
          for (Eigen::Index k = 0; k < 3; ++k)
            EXPECT_NEAR(places[i].at[static_cast<std::size_t>(k)], tip[k], rounding.mm);
          EXPECT_NEAR(places[i].at[kTilt], meant.at.a.in_degrees(), rounding.deg);
          EXPECT_NEAR(std::remainder(places[i].at[kTurn] - meant.at.c.in_degrees(), modulo ? 360 : 1e9), 0,
                      rounding.deg);
          // C goes on from place to place, never once round.
          const double before = i > 0 ? places[i - 1].at[kTurn] : places[i].at[kTurn];
          EXPECT_LT(std::abs(places[i].at[kTurn] - before), 2);
        }
        EXPECT_THAT(text, Not(HasSubstr("-0.00000 ")));
      }
}

/// Every block is one that `correct` follows, and a machine without errors leaves the text as it is.
TEST(PieceProgram, IsReadWithoutARefusalInEveryDialect) {
  const Planned planned;
  for (const auto& [name, rounding] : kRounding) {
    const PieceProgramStyle style{.dialect = name};
    const std::string text = piece_program(planned.piece, planned.path, planned.chain, style);
    Shop shop("w C' A' Y' b X Z t", 0);
    shop.how.dialect = name;
    shop.how.scan = reading(planned, style);
    EXPECT_EQ(shop.correct(text), text) << name;
    EXPECT_GT(shop.result.counts.corrected_blocks, planned.path.size()) << name;
  }
}

TEST(PieceProgram, SaysWhoseItIs) {
  const Planned planned;
  for (const char* name : {"fanuc", "sinumerik", "heidenhain"})
    EXPECT_EQ(told_dialect(piece_program(planned.piece, planned.path, planned.chain, {.dialect = name})), name);
}

TEST(PieceProgram, ComesFromAboveAndLeavesClearOfThePiece) {
  Planned planned;
  planned.piece.feed_mm_per_min = 450;
  const std::string text = piece_program(planned.piece, planned.path, planned.chain);
  EXPECT_THAT(text, HasSubstr("\nG0 X"));
  EXPECT_THAT(text, HasSubstr(" F450.0\n"));
  EXPECT_TRUE(text.ends_with("\nM2\n"));
  // Finer steps pass through the same places.
  const std::vector<PlayedPlace> coarse = played_places(opened(text), {}, 1e3, 1e3),
                                 fine = played_places(opened(text), {}, 0.1, 0.1);
  EXPECT_GT(fine.size(), 3 * coarse.size());
  EXPECT_EQ(fine.back().at, coarse.back().at);
}

}  // namespace
}  // namespace trunnion
