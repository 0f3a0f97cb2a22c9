#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "shop.h"

namespace trunnion {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kAlongArc_mm = 3e-4;  // tolerance 0.2 um and the rounding of the words

/// An arc as the test knows it: where it is after the part s.
struct Way {
  std::string block;
  std::array<double, 5> begin, end;
  std::size_t first, second;  // axes that turn
  std::array<double, 2> centre;
  double sweep_rad;

  testing::PlayedMove at(double s) const {
    testing::PlayedMove move;
    for (std::size_t i = 0; i < 5; ++i) move.at[i] = begin[i] + s * (end[i] - begin[i]);
    const double a = begin[first] - centre[0], b = begin[second] - centre[1];
    move.at[first] = centre[0] + a * std::cos(s * sweep_rad) - b * std::sin(s * sweep_rad);
    move.at[second] = centre[1] + a * std::sin(s * sweep_rad) + b * std::cos(s * sweep_rad);
    return move;
  }
};

constexpr double kHalf = std::numbers::pi;
const std::array<double, 5> kBegin = {10, 20, 30, -40, 50};

const Way kArcs[] = {
    {"G17 G3 X0 Y30 I-10 J0", kBegin, {0, 30, 30, -40, 50}, 0, 1, {0, 20}, kHalf / 2},
    {"G2 X0 Y30 I0 J10", kBegin, {0, 30, 30, -40, 50}, 0, 1, {10, 30}, -kHalf / 2},
    {"G02 X0 Y30 I0 J10 Z25 A-43 C60 (helix)", kBegin, {0, 30, 25, -43, 60}, 0, 1, {10, 30}, -kHalf / 2},
    {"G3 I-10", kBegin, kBegin, 0, 1, {0, 20}, 2 * kHalf},
    {"G3 I-10 P3 Z33", kBegin, {10, 20, 33, -40, 50}, 0, 1, {0, 20}, 6 * kHalf},
    {"G3 X0 Y30 R10", kBegin, {0, 30, 30, -40, 50}, 0, 1, {0, 20}, kHalf / 2},
    {"G3 X0 Y30 R-10", kBegin, {0, 30, 30, -40, 50}, 0, 1, {10, 30}, 1.5 * kHalf},
    {"G2 X0 Y30 R10", kBegin, {0, 30, 30, -40, 50}, 0, 1, {10, 30}, -kHalf / 2},
    {"G90.1 G3 X0 Y30 I0 J20", kBegin, {0, 30, 30, -40, 50}, 0, 1, {0, 20}, kHalf / 2},
    {"G91 G3 X-10 Y10 I-10 J0", kBegin, {0, 30, 30, -40, 50}, 0, 1, {0, 20}, kHalf / 2},
    // G18 turns from Z to X, G19 from Y to Z.
    {"G18 G3 X20 Z20 K-10", kBegin, {20, 20, 20, -40, 50}, 2, 0, {20, 10}, kHalf / 2},
    {"G19 G3 Y10 Z40 J-10", kBegin, {10, 10, 40, -40, 50}, 1, 2, {10, 30}, kHalf / 2},
    {"G19 G2 Y10 Z40 K10", kBegin, {10, 10, 40, -40, 50}, 1, 2, {20, 40}, -kHalf / 2},
};

std::string program_with(const std::string& block) {
  return "G21 G0 X10 Y20 Z30 A-40 C50\nG1 X10 F500\n" + block + "\n";
}

/// Small errors move and turn an arc: end and centre follow, it stays one.
TEST(Arcs, FollowWithEndAndCentre) {
  Shop shop;
  const std::string out = shop.correct(program_with("G3 X0 Y30 I-10 J0\nG90.1 G2 X-10 Y40 I-10 J30"));
  EXPECT_EQ(shop.result.counts.inserted_blocks, 0u) << out;
  EXPECT_THAT(out, HasSubstr("G3 X-0.0121 Y30.0031 I-10 J0"));
  EXPECT_THAT(out, HasSubstr("I-10.0121 J30.0032"));
}

TEST(Arcs, BecomeChainsOfLinesThatFollowThem) {
  int chains = 0;
  for (const bool tcp : {true, false})
    for (const Way& way : kArcs) {
      Shop shop;
      shop.how.scan.tcp = tcp;
      const std::string out = shop.correct(program_with(way.block));
      if (shop.result.counts.inserted_blocks == 0) continue;  // a turned circle is one still
      ++chains;
      EXPECT_THAT(out, Not(HasSubstr("I"))) << out.substr(0, 400);
      const auto sent = testing::play_rs274(out, {});
      ASSERT_GT(sent.size(), 20u) << way.block;
      const std::size_t n = sent.size() - 2;
      double minutes = 0;
      for (std::size_t k = 1; k <= n; ++k) {
        minutes += sent[k + 1].minutes;
        for (const double s : {0.3, 0.5, 1.0}) {
          testing::PlayedMove at;
          for (std::size_t i = 0; i < 5; ++i) at.at[i] = sent[k].at[i] + s * (sent[k + 1].at[i] - sent[k].at[i]);
          const Miss left = shop.missed(way.at((static_cast<double>(k) - 1 + s) / static_cast<double>(n)), at);
          ASSERT_LT(left.tip_mm, kAlongArc_mm) << way.block << " piece " << k << " of " << n << "\n"
                                               << out.substr(0, 500);
          ASSERT_LT(left.axis_rad, 8e-6) << way.block;
        }
      }
      const double radius = std::hypot(way.begin[way.first] - way.centre[0], way.begin[way.second] - way.centre[1]);
      const std::size_t third = 3 - way.first - way.second;
      const double length = std::hypot(radius * way.sweep_rad, way.end[third] - way.begin[third]);
      EXPECT_NEAR(minutes, length / 500, 1e-3 * length / 500) << way.block;
    }
  EXPECT_GT(chains, 5);
}

/// The same six numbers everywhere: a shift of the part, and nothing else.
class ShiftField : public ErrorField {
 public:
  PoseError at(const Situation&) const override { return {.translation_mm = {0.01, -0.02, 0.005}}; }
  Range<Angle> tilt_range() const override { return {Angle::degrees(-120), Angle::degrees(120)}; }
};

std::string shifted(const std::string& program) {
  Shop shop;
  const ShiftField field;
  const Corrector on(shop.chain, field, {.tcp = ToolCentrePoint::off});
  std::string out;
  const OpenProgram open = [&]() -> ReadBytes {
    return [program, at = std::size_t{0}](char* buffer, std::size_t size) mutable {
      const std::size_t n = program.copy(buffer, size, at);
      at += n;
      return n;
    };
  };
  correct_program(
      open, [&](std::string_view text) { out += text; }, on, on, shop.how);
  return out.substr(out.find('\n') + 1);
}

TEST(Arcs, ThatAreOnlyShiftedStayArcs) {
  EXPECT_EQ(shifted("G0 X10 Y20 Z30 A-40 C50\nG3 X0 Y30 I-10 F100\nX-10 Y20 J-10\n"),
            "G0 X10.01 Y19.98 Z30.005 A-40 C50\nG3 X0.01 Y29.98 I-10 F100\nX-9.99 Y19.98 J-10\n");
  EXPECT_EQ(shifted("G0 X10 Y20 Z30 A-40 C50\nG3 I-10 F100\n"), "G0 X10.01 Y19.98 Z30.005 A-40 C50\nG3 I-10 F100\n");
}

TEST(Arcs, KeepTheirBytesWithoutErrors) {
  Shop shop("w C' A' Y' b X Z t", 0);
  for (const Way& way : kArcs) EXPECT_EQ(shop.correct(program_with(way.block)), program_with(way.block));
}

TEST(Arcs, LeaveTheModalCodeAsItWas) {
  Shop shop;
  const std::string out = shop.correct(program_with("G3 X0 Y30 I-10 C70\nX-10 Y20 J-10 C90\nG1 X5"));
  const auto sent = testing::play_rs274(out, {});
  const Way second{"", {0, 30, 30, -40, 70}, {-10, 20, 30, -40, 90}, 0, 1, {0, 20}, kHalf / 2};
  bool found = false;
  for (const testing::PlayedMove& move : sent) found |= shop.missed(second.at(0.5), move).tip_mm < 0.2;
  EXPECT_TRUE(found);
  EXPECT_THAT(out, Not(HasSubstr("G3")));
}

TEST(Arcs, DoNotDependOnChunks) {
  Shop shop;
  std::string program = program_with("G3 X0 Y30 I-10\nX-10 Y20 J-10\nG1 X5\nG2 X10 Y10 R20\nX20 R7");
  const std::string whole = shop.correct(program);
  for (const std::size_t chunk : {16u, 30u, 50u}) {
    shop.how.chunk_bytes = chunk;
    EXPECT_EQ(shop.correct(program), whole);
  }
}

TEST(Arcs, ThatCannotBeAreToldByLine) {
  const std::pair<const char*, const char*> bad[] = {
      {"G3 X0 Y30", "an arc without centre or radius"},
      {"G3 X0 Y30 I-10 R10", "an arc with both a radius and a centre"},
      {"G3 X0 Y30 I-5", "an arc whose end does not lie on it"},
      {"G3 X0 Y30 R2", "an arc whose radius does not reach its end"},
      {"G3 R2", "G3 without axis words"},
      {"G3 X10 Y20 R2", "an arc by radius that ends where it begins"},
      {"G3 X0 Y30 I0 J0", "an arc of radius zero"},
      {"G3 X0 Y30 I-10 K1", "an arc with a centre word that is not of its plane"},
      {"G3 X0 Y30 I-10 P1.5", "P of an arc is a whole number of turns, 1 or more"},
      {"G90.1 G3 X0 Y30 I0", "an arc with an absolute centre wants both centre words"},
      {"G1 X0 I5", "I, J, K or R in a block that is no arc"},
      {"G3 X0 Y30 I-10 I-10", "I stands twice in one block"},
      {"G64 G3 X0 Y30 I-10 P2", "P in a block with an arc and G4 or G64 has two meanings"},
  };
  for (const auto& [block, message] : bad) {
    Shop shop;
    EXPECT_EQ(shop.refusal(program_with(block)), std::string("part.ngc:3: ") + message) << block;
  }
  Shop shop;
  EXPECT_EQ(shop.refusal("G0 X0 Y0 Z0 A-30\nG3 X5 Y5 I5 C0 F10\n"),
            "part.ngc:2: an arc in the block that first makes all axes known");
}

}  // namespace
}  // namespace trunnion
