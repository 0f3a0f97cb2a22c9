#include <gmock/gmock.h>

#include "shop.h"

namespace trunnion {
namespace {

constexpr const char* kOptionalModes =
    "/ before a block that changes modes, zeros or tools, or ends the program: whether it runs is not known";

struct Refused {
  std::string_view block;
  std::string_view reason;
};

// Each stands on line 2, behind a block that makes all axes known.
const Refused kRefused[] = {
    {"G5 X5 I2 J0 P1 Q1", "G5: splines are not corrected; post the program with lines"},
    {"G5.2 X5 Y1 P1 L3", "G5.2: splines are not corrected; post the program with lines"},
    {"G41 D1 C20",
     "G41 or G42 is active while a rotary axis moves: cutter radius compensation is not corrected there; post the "
     "tool's centre path"},
    {"G42.1 D3 G1 A-20",
     "G41 or G42 is active while a rotary axis moves: cutter radius compensation is not corrected there; post the "
     "tool's centre path"},
    {"G81 X1 Z-5 R2 F100", "G81: a canned cycle; post the program with its single moves"},
    {"G73 X1 Z-5 R2 Q1 F100", "G73: a canned cycle; post the program with its single moves"},
    {"G76 P1 Z-1 I1 J1 K1", "G76: a canned cycle; post the program with its single moves"},
    {"G33 Z-5 K1", "G33: spindle-synchronised motion"},
    {"G38.2 Z-5 F10", "G38.2: probing ends where the part is, not where a program can say"},
    {"G80 X5", "axis words without a motion code"},
    {"G7", "G7: diameter programming belongs to a lathe"},
    {"G10 L2 P1 X0", "G10: sets offsets or tools while the program runs; give them in the job"},
    {"G10 L2 P1 R30", "G10: sets offsets or tools while the program runs; give them in the job"},
    {"G17.1", "G17.1: planes of U V W"},
    {"G68 X0 Y0 R30", "G68 is not known to dialect linuxcnc"},
    {"G43.4 H1", "G43.4 is not known to dialect linuxcnc"},
    {"X#1", "X is not followed by a plain number; variables and expressions in motion words are not computed"},
    {"Y", "Y is not followed by a plain number; variables and expressions in motion words are not computed"},
    {"X[1+2]", "X is not followed by a plain number; variables and expressions in motion words are not computed"},
    {"G#1", "G is not followed by a plain number; variables and expressions in motion words are not computed"},
    {"#5221=3", "#5221: a parameter of the control itself, it may move its zero"},
    {"#[1+1]=3", "# parameter by a computed number"},
    {"o100 sub", "O word: subprograms and loops; post the program without them"},
    {"O<name> call", "O word: subprograms and loops; post the program without them"},
    {"M98 P100", "M98: subprogram call; post the program without it"},
    {"M70", "M70: saved and restored modes are not followed"},
    {"M200", "M200 is not known to dialect linuxcnc"},
    {"B5", "B: this machine has no such axis"},
    {"U1", "U: this machine has no such axis"},
    {"/ G1 X5 F100", "/ before a block that moves: whether it runs is not known"},
    {"/ G28 X0", "/ before G28: whether it runs is not known"},
    {"/ G91", kOptionalModes},
    {"/ G1", kOptionalModes},
    {"/ G43 H1", kOptionalModes},
    {"/ T2 M6", kOptionalModes},
    {"/ M30", kOptionalModes},
    {"G2 X3 Y2 I1 J0 P#1", "P, the turns of an arc, is not followed by a plain number"},
    {"G1 C90", "F is not known, so the duration of this turn cannot be kept"},
    {"G95 G1 C90 F1", "a turn of the rotary axes in G95 whose X Y Z correction would change its duration"},
    {"G1 C90 F100 M0", "a move that must be divided stands in one block with a program stop; give each its own block"},
};

const Refused kBad[] = {
    {"X1 X2", "X stands twice in one block"},
    {"F1 F2", "F stands twice in one block"},
    {"F-1", "F is negative"},
    {"F10000000000", "F is beyond 1000000000"},
    {"X1000001", "X is beyond 1000000"},
    {"G3 X1 I-99999999999999999", "I is beyond 1000000"},
    {"G0 G1 X5", "G0 and G1 in one block"},
    {"G28 G92 X0", "G28 and G92 in one block"},
    {"G92", "G92 without axis words"},
    {"G1.23", "G code that does not exist"},
    {"G-1", "G code that does not exist"},
    {"M3.5", "M3.5: an M code is a whole number"},
    {"X5 (open", "a comment that is not closed: (open"},
    {"X5 ?", "'?' is no word of a block"},
    {"X1.2.3", "'.3' is no word of a block"},
    {"X5 % Y2", "% in a block; it stands on a line of its own"},
    {"%", "% in a program that does not begin with one"},
    {"$1", "'$1' is no word of a block"},
    {"S1 E", "E is no word of this dialect, or its number is missing or has more than 18 digits"},
};

std::string told(std::string_view block) {
  Shop shop;
  return shop.refusal("G0 X1 Y2 Z3 A-4 C5\n" + std::string(block) + "\nM2\n");
}

TEST(Refusals, TellLineAndReason) {
  for (const Refused& refused : kRefused) {
    EXPECT_EQ(told(refused.block), "part.ngc:2: " + std::string(refused.reason)) << refused.block;
  }
  for (const Refused& bad : kBad) EXPECT_EQ(told(bad.block), "part.ngc:2: " + std::string(bad.reason)) << bad.block;
}

TEST(Refusals, AreOfTheRightKind) {
  Shop shop;
  for (const Refused& bad : kBad)
    EXPECT_THROW(shop.correct("G0 X1 Y2 Z3 A-4 C5\n" + std::string(bad.block) + "\n"), InputError) << bad.block;
  for (const Refused& refused : kRefused)
    EXPECT_THROW(shop.correct("G0 X1 Y2 Z3 A-4 C5\n" + std::string(refused.block) + "\n"), RefusalError)
        << refused.block;
}

TEST(Refusals, TellTheFirstOfSeveral) {
  Shop shop;
  shop.how.chunk_bytes = 32;
  shop.how.threads = 4;
  std::string program = "G0 X1 Y1 Z1 A-10 C0\n";
  for (int i = 0; i < 200; ++i) program += "G1 X" + std::to_string(i % 7) + " F100\n";
  program += "A-121\nG5 X5 I1\nX1 X1\n";
  EXPECT_EQ(shop.refusal(program), "part.ngc:202: A-121: outside the probed range -120 ... 120 deg");
}

TEST(Refusals, WantAWorkOffsetWhereTheJobGivesAny) {
  Shop shop;
  shop.how.scan.work_offsets_mm = {{"G54", {1, 2, 3}}};
  EXPECT_EQ(shop.refusal("G0 X1 Y2 Z3 A-4 C5\nG59.3\nX5\n"), "part.ngc:3: G59.3: the job gives no work offset for it");
}

TEST(Refusals, SpareWhatDoesNotMove) {
  Shop shop("w C' A' Y' b X Z t", 0);
  const std::string program =
      "#1=5\n#<a b>=[3+#1]\nG17 G40 G49 G64 P0.01\nT1 M6\nG0 X1 Y2 Z3 A-4 C5\n/ M8\n/ (NO MOVE) S500 F200\nS#1 M3\nG4 "
      "P[1]\nG41 "
      "D1\nG40\n(MSG, hello)\n"
      "M62 P0\nG28.1\nG43 H1\nM101 P1\nM0\nG1 Z5 F100 M9\nM30\n";
  EXPECT_EQ(shop.refusal(program), program);
}

}  // namespace
}  // namespace trunnion
