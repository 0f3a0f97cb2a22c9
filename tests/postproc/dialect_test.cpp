#include "postproc/dialect.h"

#include <gmock/gmock.h>

#include <cmath>

#include "played_pairs.h"

namespace trunnion {
namespace {

constexpr double kWrittenTip_mm = 2.2e-4;  // 0.2 um and what four decimals leave
constexpr double kBetween_mm = 3.2e-4;     // the tolerance and the rounding of both ends
constexpr double kWrittenAxis_rad = 8e-6;  // beyond 5 deg of tilt

Shop shop_of(const std::string& dialect, double scale = 1, const std::string& structure = "w C' A' Y' b X Z t") {
  Shop shop(structure, scale);
  shop.how.dialect = dialect;
  shop.how.keep_insertions = true;
  shop.how.scan.tcp = false;
  shop.how.scan.tilt_stroke_deg = {-120, 30};
  return shop;
}

std::string corrected(Shop& shop, std::string_view program) {
  shop.how.scan.chain = &shop.chain;
  return shop.correct(program);
}

/// A finishing path over a cap in the words of a dialect.
std::string path(const char* line_format, const char* head, const char* tail, int lines = 40) {
  std::string text = head;
  char line[200];
  for (int i = 1; i <= lines; ++i) {
    const double t = 0.03 * i;
    std::snprintf(line, sizeof line, line_format, 10 * i, 40 * std::cos(t), 40 * std::sin(t), 50 - 0.1 * i,
                  -20 - 0.8 * i, 57.29578 * t);
    text += line;
  }
  return text + tail;
}

const std::string kFanucBlade = path("N%d X%.3f Y%.3f Z%.3f A%.3f C%.3f\n",
                                     "%\nO0001 (BLADE)\nG21 G90 G94 G17 G40 G49 G80\nG54\nT1 M6\nS9000 M3\nG0 A-20. "
                                     "C0.\nG43.4 H1 X40. Y0. Z60.\nG1 Z50. F1500.\n",
                                     "C90. F800.\nG3 X20. Y20. R30.\nG2 X10. Y10. I-10. J0.\nG1 X40. Y-20. Z30. A-60. "
                                     "C190. F2000.\nG91 X1. C2.\nG90 G20 X1.5\nG21 G49\nG28 G91 Z0.\nM30\n%\n");
const std::string kFanucVectors =
    "%\nO2\nG21 G90 G54\nG0 A-30. C0.\nG43.5 H1 X30. Y0. Z60. I0. J-0.5 K0.8660254;\n"
    "G1 Z40. F1500.;\nX31. Y1. I0.05 J-0.52 K0.8526429;\nX32.;\nX33. Y3. I0.1 J-0.55 K0.8291562;\n"
    "X33. Y20. I0.3 J-0.55 K0.7794229;\nG49;\nM30;\n%\n";
const std::string kFanucPocket =
    "%\nO3\nG21 G90 G17 G54\nT2 M6\nG68.2 X10. Y-5. Z20. I30. J-40. K10.\nG53.1\nG43 H2 Z50.\nG0 X0. Y0.\nZ5.\n"
    "G1 Z-2. F200.\nX20. F600.\nG3 X25. Y5. J5.\nG1 Y40.\nX0.\nG91 Y-10.\nG90 G0 Z50.\nG69\nG49\nM30\n%\n";
const std::string kSinumerikBlade = path(
    "N%d X%.3f Y%.3f Z%.3f A=%.3f C=%.3f\n",
    "%_N_BLADE_MPF\n;$PATH=/_N_WKS_DIR\nN1 G710 G90 G17 G40 G94\nN2 MSG(\"BLADE\")\nN3 G54\nN4 T=\"MILL\" D1\nN5 M6\n"
    "TRAORI\nORIWKS ORIAXES\nG0 X40 Y0 Z60 A=-20 C=0\nG1 Z50 F1500\n",
    "X=IC(1) Y=AC(30) Z=20 C=DC(80)\nG3 X20 Y40 CR=30\nG2 X10 Y30 I-10 J=AC(40)\nCIP X12 Y20 Z22 I1=12 J1=26 K1=21\n"
    "G1 X13 Y19\nCT X18 Y20\nG1 A3=0.1 B3=-0.55 C3=0.8291562 X41 Y-20 Z10\nX42\nA3=0.12 B3=-0.57 C3=0.8128345 X43\n"
    "TRANS X10 Y5\nG0 X0 Y0 Z80 A=-20 C=30\nATRANS Z-10\nG1 Z60 F500\nTRANS\nTRAFOOF\nSUPA G0 Z0 D0\nM30\n");
const std::string kSinumerikPocket =
    "G710 G90 G17\nG54\nT1 D1\nM6\nCYCLE800(1,\"TC1\",200000,57,10,-5,20,-40,0,30,1,2,3,-1,,1)\nG0 X0 Y0\nZ50\nG1 Z-2 "
    "F200\nX20 F600\nG3 X25 Y5 J5 I0\nG1 Y20\nATRANS X5\nG1 X30 Y5\nG0 Z50\nCYCLE800()\nM30\n";
const std::string kHeidenhainBlade = path(
    "%d L X%+.3f Y%+.3f Z%+.3f A%+.3f C%+.3f\n",
    "0 BEGIN PGM BLADE MM\n1 BLK FORM 0.1 Z X-50 Y-50 Z-20\n2 TOOL CALL 5 Z S9000\n3 M126\n4 L A-20 C+0 R0 FMAX "
    "M3\n5 M128 F2000\n6 L X+40 Y+0 Z+60 R0 FMAX\n7 L Z+50 F1500\n",
    "500 L C+120 F800\n501 L X+20 Y+36\n502 CC X+10 Y+36\n503 C X+10 Y+46 DR+\n503 CR X+13 Y+40 R-10 DR-\n504 L IX+1 "
    "IY-2 IC+2\n505 "
    "CT X+20 Y+40\n506 LN X+21 Y+40 Z+40 TX+0.1 TY-0.55 TZ+0.8291562\n507 CC IX+5 IY+0\n508 CP IPA+400 IZ-3 "
    "DR+\n509 L Z+80 R0 FMAX\n510 M129\n511 CYCL DEF 7.0 DATUM\n512 CYCL DEF 7.1 X+10\n513 CYCL DEF 7.2 IY-5\n514 L "
    "Z-10 R0 FMAX M91\n515 L X+5 Y+5 Z+90 A-30 C+20 FMAX\n516 L Z+80 F300\n517 M30\n518 END PGM BLADE MM\n");
const std::string kHeidenhainPocket =
    "BEGIN PGM POCKET INCH\nTOOL CALL 2 Z S5000\nPLANE SPATIAL SPA-40 SPB+0 SPC+30 TURN FMAX SEQ- TABLE ROT\nL X+0 Y+0 "
    "R0 FMAX\nL Z+2,0 FMAX\nL Z-0,1 F20\nL X+0,8\nCC X+0.8 Y+0.2\nC X+1 Y+0.2 DR+\nL IY+0.8\nL Z+2 FMAX\nPLANE RESET "
    "STAY\nM2\nEND PGM POCKET INCH\n";

struct Program {
  const char* dialect;
  const std::string* text;
  bool indexed = false;  ///< the control turns the axes: the tool axis is not corrected
};
const Program kPrograms[] = {
    {"fanuc", &kFanucBlade},
    {"fanuc", &kFanucVectors},
    {"fanuc", &kFanucPocket, true},
    {"sinumerik", &kSinumerikBlade},
    {"sinumerik", &kSinumerikPocket, true},
    {"heidenhain", &kHeidenhainBlade},
    {"heidenhain", &kHeidenhainPocket, true},
};

void expect_on_its_path(const Shop& shop, std::string_view program, const std::string& out, bool indexed) {
  const auto pairs = played_pairs(shop, program, out);
  EXPECT_GT(pairs.size(), 3u);
  double before = 0;
  for (const PlayedPair& pair : pairs) {
    const Miss left = missed(shop, pair, true);
    EXPECT_LT(left.tip_mm, pair.part == 1 ? kWrittenTip_mm : kBetween_mm) << pair.line << " " << pair.part;
    EXPECT_TRUE(indexed || left.axis_rad < kWrittenAxis_rad) << left.axis_rad << " " << pair.line << " " << pair.part;
    before = std::max(before, missed(shop, pair, false).tip_mm);
  }
  EXPECT_GT(before, 0.005);
}

TEST(Dialects, ChangeNoByteWithoutErrors) {
  for (const Program& program : kPrograms)
    for (const char* end : {"\n", "\r\n", "\n\r\r"}) {
      std::string text;
      for (const char c : *program.text) c == '\n' ? text += end : text += c;
      Shop shop = shop_of(program.dialect, 0);
      EXPECT_TRUE(corrected(shop, text) == text) << program.dialect;
      EXPECT_FALSE(shop.result.counts.changed());
      EXPECT_GT(shop.result.counts.corrected_blocks, 4u) << text;
    }
}

TEST(Dialects, BringTheToolToItsPathOnTheExactMachine) {
  for (const Program& program : kPrograms) {
    SCOPED_TRACE(*program.text);
    Shop shop = shop_of(program.dialect);
    shop.how.scan.work_offsets_mm = {{"G54", {3, -2, 4}}};
    const std::string out = corrected(shop, *program.text);
    expect_on_its_path(shop, *program.text, out, program.indexed);
  }
}

TEST(Dialects, DoNotDependOnChunksOrThreads) {
  for (const Program& program : kPrograms) {
    Shop shop = shop_of(program.dialect);
    const std::string whole = corrected(shop, *program.text);
    for (const std::size_t chunk : {16u, 300u, 1000u})
      for (const int threads : {1, 3}) {
        shop.how.chunk_bytes = chunk;
        shop.how.threads = threads;
        EXPECT_TRUE(corrected(shop, *program.text) == whole) << chunk << " " << threads;
      }
  }
}

TEST(Dialects, RefuseWhatTheyHaveCorrected) {
  for (const Program& program : kPrograms) {
    Shop shop = shop_of(program.dialect);
    const std::string once = corrected(shop, *program.text);
    EXPECT_THAT(shop.refusal(once), ::testing::HasSubstr("corrected already")) << once.substr(0, 200);
  }
}

TEST(Fanuc, TakesTheFrameOfTheTipAsTheMachineFileSays) {
  const std::string program =
      "G21 G90 G54\nG0 A-25. C40.\nG43.4 H1 X30. Y10. Z60.\nG1 X31. Z58. F500.\nX33. Y12. Z57. A-28. "
      "C46.\nC90.\nG49\nM30\n";
  std::string texts[3];
  int i = 0;
  for (const char* frame : {"zero", "start", "fixed"}) {
    Shop shop = shop_of("fanuc");
    shop.how.scan.control.tcp_frame = frame;
    shop.how.scan.work_offsets_mm = {{"G54", {3, -2, 4}}};
    texts[i] = corrected(shop, program);
    expect_on_its_path(shop, program, texts[i], false);
    ++i;
  }
  EXPECT_NE(texts[0], texts[1]);
  EXPECT_NE(texts[1], texts[2]);
}

TEST(Fanuc, ReadsWholeNumbersAsTheMachineFileSays) {
  const std::string program = "G21 G90\nG0 X10000 Y20000 Z50000 A-30000 C0\nG1 X11000 F500\nY21500 C2000\n";
  Shop shop = shop_of("fanuc");
  EXPECT_THAT(shop.refusal(program), ::testing::HasSubstr("X10000 has no point"));
  shop.how.scan.control.whole_numbers = "increments";
  const std::string out = corrected(shop, program);
  EXPECT_THAT(out, ::testing::HasSubstr("X9.99"));
  expect_on_its_path(shop, program, out, false);
}

TEST(Fanuc, TurnsCTheShorterWay) {
  // 359 to 1 is two degrees: nothing to divide, and words stay within a turn.
  Shop shop = shop_of("fanuc");
  const std::string program =
      "G21 G90\nG43.4 H1\nG0 X40. Y0. Z50. A-30. C359.\nG1 C1. X41. F500.\nX42. C0.\nX43. C359.999\nX44. C340.\nX45. "
      "C10.\n";
  const std::string out = corrected(shop, program);
  expect_on_its_path(shop, program, out, false);
  EXPECT_EQ(out.find("C-"), std::string::npos) << out;
  EXPECT_EQ(out.find("C36"), std::string::npos) << out;
  EXPECT_LT(shop.result.counts.inserted_blocks, 20u);
}

TEST(Dialects, CorrectOnOtherStructures) {
  for (const char* structure : {"w C' A' Y' b X Z t", "w C' B' X' b Y Z t", "w C' b X Y Z B t", "w b X Y Z C B t"}) {
    SCOPED_TRACE(structure);
    std::string program = kHeidenhainBlade.substr(0, kHeidenhainBlade.find("506 LN")) + "M129\nL X+1 Y+1 Z+90\nM30\n";
    Shop shop = shop_of("heidenhain", 1, structure);
    shop.settings.tool_length_mm = 80;
    if (shop.both.machine.tilt_letter() == 'B')
      for (std::size_t at = 0; (at = program.find(" A", at)) != std::string::npos; ++at) program[at + 1] = 'B';
    shop.how.guard.stroke = {};
    expect_on_its_path(shop, program, corrected(shop, program), false);
  }
}

Assumptions assumed(const char* dialect, const std::string& program) {
  Shop shop = shop_of(dialect);
  shop.correct(program);
  return shop.result.counts.assumptions;
}

TEST(Dialects, TellWhatNobodyHasConfirmed) {
  const std::string klartext = "1 L A-30 C+10 FMAX\n2 M128\n3 L X+1 Y+1 Z+2 FMAX\n4 L X+1.5 F50\n";
  EXPECT_EQ(assumed("heidenhain", "0 BEGIN PGM A MM\n" + klartext), 0);
  EXPECT_EQ(assumed("heidenhain", "0 BEGIN PGM A INCH\n" + klartext), only(Assumption::feed_in_tenths_of_inch));
  const std::string turn = "G0 A=-30 C=10\nG0 X1 Y2 Z50\nG1 X2 A=-32 C=11 F500\n";
  EXPECT_EQ(assumed("sinumerik", "TRAORI\nORIAXES\n" + turn), 0);
  EXPECT_EQ(assumed("sinumerik", "TRAORI\nORIVECT\n" + turn), only(Assumption::great_circle));
  EXPECT_EQ(assumed("sinumerik", "G58\n" + turn), only(Assumption::offset_without_words));
  const std::string fanuc = "G21 G90\nG0 X1. Y2. Z50. A-30. C10.\nG1 X2. F500.\n";
  EXPECT_EQ(assumed("fanuc", fanuc), 0);
  EXPECT_EQ(assumed("fanuc", "G5 P10000\n" + fanuc), only(Assumption::high_speed_by_number));
  EXPECT_EQ(assumed("fanuc", fanuc + "A-60. C100.\n"), only(Assumption::feed_over_all_axes));
}

TEST(Dialects, AreToldByTheirPrograms) {
  EXPECT_EQ(told_dialect("0 BEGIN PGM A MM\n"), "heidenhain");
  EXPECT_EQ(told_dialect("N10 traori\n"), "sinumerik");
  EXPECT_EQ(told_dialect("%\nO1\nG43.4 H1\n"), "fanuc");
  EXPECT_EQ(told_dialect("G0 X1 Y2\n"), "");
  EXPECT_EQ(told_dialect("(WAS TRAORI)\nG0 X1(G43.4) Y2 ; BEGIN PGM\nX=3 ;$PATH A3=\n"), "");
  EXPECT_EQ(told_dialect("N1 MSG(\"HALLO\")\n"), "sinumerik");
  for (const Program& program : kPrograms) EXPECT_EQ(told_dialect(*program.text), program.dialect);
}

}  // namespace
}  // namespace trunnion
