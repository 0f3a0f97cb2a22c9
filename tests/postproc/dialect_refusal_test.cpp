#include <gmock/gmock.h>

#include "played_pairs.h"

namespace trunnion {
namespace {

struct Told {
  const char* dialect;
  std::string block;   ///< behind a block that makes all axes known
  std::string reason;  ///< of the last of its lines
};

const std::string kSinumerikModes =
    "/ before a block that changes modes, zeros or tools, or ends the program: whether it runs is not known";
const std::string kVectors = "TRAORI\nG0 X1 Y2 Z3 A=-30 C=0\n";

const Told kTold[] = {
    {"heidenhain", "CYCL DEF 220 POLAR PATTERN ~",
     "cycle 220: runs where it is defined; post the program with its single moves"},
    {"heidenhain", "CYCL DEF 410 DATUM INSIDE RECTAN. ~",
     "cycle 410: runs where it is defined; post the program with its single moves"},
    {"heidenhain", "CYCL DEF 481 CAL. TOOL LENGTH",
     "cycle 481: runs where it is defined; post the program with its single moves"},
    {"heidenhain", "FN 25: PRESET = X/+0/+0", "FN 25: sets the control's own data, it may move its zero"},
    {"heidenhain", "/ M128", "/ before a block: whether it runs is not known"},
    {"heidenhain", "/ 7 L X+5 F100", "/ before a block: whether it runs is not known"},
    {"heidenhain", "/ CYCL DEF 7.1 X+5", "/ before a block: whether it runs is not known"},
    {"heidenhain", "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS REFPNT TIP-CENTER",
     "FUNCTION TCPM REFPNT TIP-CENTER: not the tip goes straight between blocks; post it with TIP-TIP"},
    {"sinumerik", "/TRAORI", kSinumerikModes},
    {"sinumerik", "/ ATRANS X5", kSinumerikModes},
    {"sinumerik", "RNDM=2", "RNDM=: rounds or breaks a corner; post the program with its single moves"},
    {"sinumerik", kVectors + "ORIMKS\nG1 A3=0 B3=-0.5 C3=0.8 F100",
     "a tool axis by A3= B3= C3= under ORIMKS does not turn with the workpiece"},
    {"sinumerik", kVectors + "G1 A3=0 B3=-0.5 C3=0.8660254 F500\nX50 A3=0.6 B3=0.3 C3=0.7416198",
     "how the tool turns between two axes told as vectors is not known; program ORIAXES or ORIVECT, say "
     "orientation_path under [control] of the machine file, or post shorter moves"},
    {"sinumerik", kVectors + "ORIVECT\nG1 A=-60 C=0 F500\nA=-120 C=180",
     "the tool turns about, and by which way is not told; post shorter moves"},
    {"fanuc", "/ G49", kSinumerikModes},
    {"fanuc", "/ M30", kSinumerikModes},
    {"fanuc", "G81 X1. Z-5. R2. F100.", "G81: a canned cycle; post the program with its single moves"},
};

/// The program's first lines in each dialect.
std::string head_of(const std::string& dialect) {
  if (dialect == "heidenhain") return "BEGIN PGM P MM\nL X+1 Y+2 Z+3 A-4 C+5 R0 FMAX\n";
  if (dialect == "sinumerik") return "G710 G90\nG0 X1 Y2 Z3 A=-4 C=5\n";
  return "G21 G90\nG0 X1. Y2. Z3. A-4. C5.\n";
}

Shop shop_for(const std::string& dialect) {
  Shop shop;
  shop.how.dialect = dialect;
  shop.how.scan.tcp = false;
  shop.how.keep_insertions = true;
  return shop;
}

std::string answer(Shop& shop, const std::string& program) {
  shop.how.scan.chain = &shop.chain;
  return shop.refusal(program);
}

TEST(DialectRefusals, TellLineAndReason) {
  for (const Told& told : kTold) {
    Shop shop = shop_for(told.dialect);
    const auto line = 3 + std::count(told.block.begin(), told.block.end(), '\n');
    EXPECT_EQ(answer(shop, head_of(told.dialect) + told.block + "\n"),
              "part.ngc:" + std::to_string(line) + ": " + told.reason)
        << told.block;
  }
}

TEST(DialectRefusals, SpareWhatSaysNothingOfThePath) {
  const std::pair<const char*, const char*> spared[] = {
      {"heidenhain", "/ M8"},
      {"heidenhain", "CYCL DEF 200 DRILLING ~"},
      {"heidenhain", "CYCL DEF 32.0 TOLERANCE"},
      {"heidenhain", "CYCL DEF 19.0 WORKING PLANE"},
      {"heidenhain", "TOOL CALL \"F6 X7\" Z S1000"},
      {"sinumerik", "/ M8"},
      {"sinumerik", "ORISON"},
      {"fanuc", "/ M8"},
      {"fanuc", "G80"},
  };
  for (const auto& [dialect, block] : spared) {
    Shop shop = shop_for(dialect);
    EXPECT_THAT(answer(shop, head_of(dialect) + block + "\n"), ::testing::HasSubstr(block));
  }
}

/// What all FT of a text last, s.
double told_seconds(const std::string& text) {
  double all = 0;
  for (std::size_t at = 0; (at = text.find("FT", at)) != std::string::npos; at += 2)
    all += std::strtod(text.c_str() + at + 2, nullptr);
  return all;
}

TEST(Klartext, CountsFeedsOfInchProgramsInTenths) {
  // 0.0254 mm at 2.54 mm/min, or at 10 mm/min: the correction is longer than the move.
  const std::pair<const char*, double> programs[] = {
      {"BEGIN PGM P INCH\nL X+1 Y+1 Z+2 A-30 C+0 R0 FMAX\nL X+1.001 C+20 F1\n", 0.6},
      {"BEGIN PGM P MM\nL X+25.4 Y+25.4 Z+50.8 A-30 C+0 R0 FMAX\nL X+25.4254 C+20 F10\n", 0.1524}};
  for (const auto& [program, seconds] : programs) {
    Shop shop = shop_for("heidenhain");
    const std::string out = answer(shop, program);
    EXPECT_NEAR(told_seconds(out), seconds, 0.001) << out;
  }
}

TEST(Klartext, TakesNoFeedFromTheNameOfATool) {
  Shop shop = shop_for("heidenhain");
  const std::string out = answer(shop,
                                 "BEGIN PGM P MM\nTOOL CALL 1 Z S1000 F10\nTOOL CALL \"F6\" Z S1000\nL X+25.4 Y+25.4 "
                                 "Z+50.8 A-30 C+0 R0 FMAX\nL X+25.4254 C+20\n");
  EXPECT_NEAR(told_seconds(out), 0.1524, 0.001) << out;
}

TEST(Sinumerik, KnowsNoFeedOfG70) {
  const std::string tail = "\nG0 X1 Y1 Z2 A=-30 C=0\nG1 F10\nX1.001 C=20\n";
  Shop shop = shop_for("sinumerik");
  EXPECT_THAT(answer(shop, "G90 G70" + tail), ::testing::HasSubstr(":4: F is not known"));
  EXPECT_THAT(answer(shop, "G90 G700" + tail), ::testing::HasSubstr("G93"));
}

struct Turning {
  const char* dialect;
  const char* program;
};
const Turning kTurning[] = {
    {"sinumerik",
     "G710 G90\nTRAORI\nORIWKS ORIVECT\nG0 X40 Y0 Z60 A=-20 C=0\nG1 X41 A3=0 B3=-0.4 C3=0.916515 F1500\nX20 Y30 A3=0.6 "
     "B3=-0.3 C3=0.7416198\nX-10 Y35 Z50 A3=0.5 B3=0.4 C3=0.7681146\nX-11\nORIAXES\nX-20 A3=0.1 B3=0.6 C3=0.7937254\n"},
    {"sinumerik", "G710 G90\nTRAORI\nORIVECT\nG0 X40 Y0 Z60 A=-20 C=0\nG1 X20 Y30 Z55 A=-50 C=110 F900\nA=-10 C=100\n"},
    {"heidenhain",
     "BEGIN PGM P MM\nL A-20 C+0 R0 FMAX\nFUNCTION TCPM F TCP AXIS POS PATHCTRL VECTOR\nL X+40 Y+0 Z+60 FMAX\nL X+20 "
     "Y+30 "
     "A-50 C+110 F900\nLN X+10 Y+32 Z+50 TX+0.3 TY+0.4 TZ+0.8660254\nM128\nL X+20 Y+30 Z+60 A-20 C+0 FMAX\nL A-50 "
     "C+110 F900\n"},
};

TEST(Turning, OfTheToolKeepsToItsPlane) {
  for (const Turning& turning : kTurning) {
    Shop shop = shop_for(turning.dialect);
    shop.how.scan.tilt_stroke_deg = {-120, 30};
    const std::string out = answer(shop, turning.program);
    SCOPED_TRACE(out);
    EXPECT_GT(shop.result.counts.inserted_blocks, 5u);
    const auto pairs = played_pairs(shop, turning.program, out);
    EXPECT_GT(pairs.size(), 20u);
    for (const PlayedPair& pair : pairs) {
      const Miss left = missed(shop, pair, true);
      EXPECT_LT(left.tip_mm, 3.2e-4) << pair.line << " " << pair.part;  // the tolerance and the rounding of both ends
      EXPECT_LT(left.axis_rad, 8e-6) << pair.line << " " << pair.part;
    }
  }
}

TEST(Turning, OfVectorsIsWhatTheMachineFileSays) {
  const std::string program =
      head_of("sinumerik") + kVectors + "G1 A3=0 B3=-0.5 C3=0.8660254 F500\nX50 A3=0.6 B3=0.3 C3=0.7416198\n";
  std::string texts[2];
  for (const bool circle : {false, true}) {
    Shop shop = shop_for("sinumerik");
    shop.how.scan.control.orientation_path = circle ? "great circle" : "axes";
    texts[circle] = answer(shop, program);
    EXPECT_GT(shop.result.counts.inserted_blocks, 3u) << texts[circle];
  }
  EXPECT_NE(texts[0], texts[1]);
}

}  // namespace
}  // namespace trunnion
