#include "postproc/number.h"

#include <gmock/gmock.h>

#include <cstdio>
#include <random>

namespace trunnion {
namespace {

std::string rewritten(std::string_view text) {
  const auto scanned = scan_number(text);
  if (!scanned) return "no number";
  std::string out;
  append_number(out, scanned->number, scanned->style);
  return out;
}

TEST(Number, IsWrittenBackAsItStood) {
  for (const char* text : {"0", "1", "-1", "+1", "1.", "-1.", ".5", "-.5", "+.5", "0.5", "10.500", "007", "-007.50",
                           "00.1", "100", "123456789012345678", "0.000000000001", "+0.0", "0."})
    EXPECT_EQ(rewritten(text), text);
}

TEST(Number, MayHaveBlanksInside) {
  const auto scanned = scan_number("+0. 12\t34  Y7");
  ASSERT_TRUE(scanned);
  EXPECT_EQ(scanned->number, (Decimal{1234, 4}));
  EXPECT_EQ(scanned->length, 9u);
}

TEST(Number, EndsWhereItsDigitsEnd) {
  EXPECT_EQ(scan_number("1.5.2")->length, 3u);
  EXPECT_EQ(scan_number("12  ")->length, 2u);
  EXPECT_EQ(scan_number("3Y4")->length, 1u);
}

TEST(Number, IsNoneWithoutDigitsOrWithTooMany) {
  for (const char* text : {"", "-", "+", ".", "-.", " ", "X", "--1", "1234567890123456789", "1.1234567890123"})
    EXPECT_FALSE(scan_number(text)) << text;
}

TEST(Number, KeepsItsStyleWithAnotherValue) {
  const auto in_style_of = [](std::string_view model, Decimal number) {
    std::string out;
    append_number(out, number, scan_number(model)->style);
    return out;
  };
  EXPECT_EQ(in_style_of("10.", {100031, 4}), "10.0031");
  EXPECT_EQ(in_style_of("10", {100000, 4}), "10");
  EXPECT_EQ(in_style_of("10.", {100000, 4}), "10.");
  EXPECT_EQ(in_style_of("10.00", {100000, 4}), "10.00");
  EXPECT_EQ(in_style_of(".5", {-5031, 4}), "-.5031");
  EXPECT_EQ(in_style_of("0.5", {-5031, 4}), "-0.5031");
  EXPECT_EQ(in_style_of("-3.0", {0, 4}), "0.0");
  EXPECT_EQ(in_style_of("+3.0", {31, 4}), "+0.0031");
  EXPECT_EQ(in_style_of("+3.0", {-31, 4}), "-0.0031");
  EXPECT_EQ(in_style_of("007.5", {51000, 4}), "005.1");
  EXPECT_EQ(in_style_of(".5", {0, 4}), ".0");
}

TEST(Number, IsWrittenAsPrintfWould) {
  std::mt19937_64 random(20240607);
  for (int i = 0; i < 100000; ++i) {
    const int decimals = static_cast<int>(random() % 7);
    // From a digit to ten, so that both ways of writing and what lies between them are met.
    const std::int64_t bound = power_of_ten(1 + static_cast<int>(random() % 10));
    const Decimal number{static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(2 * bound - 1)) - bound + 1,
                         decimals};
    char wanted[64];
    std::snprintf(wanted, sizeof wanted, "%.*f", decimals, number.value());
    std::string out;
    append_number(out, number, {.point = decimals > 0, .decimals = static_cast<std::uint8_t>(decimals)});
    ASSERT_EQ(out, wanted);
    EXPECT_EQ(scan_number(out)->number, number);
  }
}

TEST(Number, AddsExactly) {
  EXPECT_EQ((Decimal{15, 1} + Decimal{25, 2}), (Decimal{175, 2}));
  EXPECT_EQ((Decimal{15, 1} - Decimal{25, 2}), (Decimal{125, 2}));
  EXPECT_EQ(rounded(-0.00005, 4).mantissa, -1);
  EXPECT_EQ(rounded(0.00004, 4).mantissa, 0);
}

}  // namespace
}  // namespace trunnion
