#include "io/csv.h"

#include <gtest/gtest.h>

#include <charconv>
#include <cmath>
#include <cstdio>
#include <random>

#include "error.h"

namespace trunnion {
namespace {

TEST(Csv, ReadsDecimalsToTheLastBitAsTheStandardLibraryDoes) {
  std::mt19937_64 random(20250101);
  for (int n = 0; n < 200000; ++n) {
    char text[48];
    const int digits = static_cast<int>(random() % 18);
    const double value = std::ldexp(static_cast<double>(random() >> 11U), -static_cast<int>(random() % 60)) - 4e3;
    const int length = std::snprintf(text, sizeof text, "%.*f", digits, value);
    double wanted = 0;
    std::from_chars(text, text + length, wanted);
    ASSERT_EQ(parse_number({text, static_cast<std::size_t>(length)}), wanted) << text;
  }
}

TEST(Csv, TakesWhatIsANumberAndNothingElse) {
  for (const char* text : {"0", "-0.5", "+3", "1e-3", ".5", "5.", "-.25", "00012", "123456789012345678"})
    EXPECT_TRUE(parse_number(text).has_value()) << text;
  for (const char* text : {"", "-", "+", ".", "-.", "1.2.3", "1,5", "0x10", "nan", "inf", "-inf", "1e999", "+-1", "--1",
                           "1 2", "1e", "12a"})
    EXPECT_FALSE(parse_number(text).has_value()) << text;
}

TEST(Csv, WritesTheShortestTextThatReadsBackAndNoNegativeZero) {
  for (const double value : {0.1, -2.5e-7, 1.0 / 3, 123456789.125, 1e22}) {
    std::string text;
    append_number(text, value);
    EXPECT_EQ(parse_number(text), value) << text;
  }
  std::string zero;
  append_number(zero, -0.0);
  EXPECT_EQ(zero, "0");
}

}  // namespace
}  // namespace trunnion
