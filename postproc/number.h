#pragma once

#include <array>
#include <cassert>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace trunnion {

/// 10^n for n = 0 ... 18.
inline constexpr std::array<std::int64_t, 19> kPowersOfTen = [] {
  std::array<std::int64_t, 19> powers{};
  std::int64_t power = 1;
  for (std::size_t i = 0; i < powers.size(); ++i, power *= i < powers.size() ? 10 : 1) powers[i] = power;
  return powers;
}();
inline std::int64_t power_of_ten(int n) {
  assert(n >= 0 && n < 19);
  return kPowersOfTen[static_cast<std::size_t>(n)];
}

/// A number of an NC word as its digits say it: value = mantissa 10^-decimals. Nothing is lost on the way from text to
/// text.
struct Decimal {
  std::int64_t mantissa = 0;
  int decimals = 0;

  double value() const { return static_cast<double>(mantissa) / static_cast<double>(power_of_ten(decimals)); }
  friend bool operator==(const Decimal&, const Decimal&) = default;
};

/// How a number was written, so that another can be written alike.
struct NumberStyle {
  bool plus = false;              ///< a positive number carries its sign
  bool point = false;             ///< a point stands even where no decimals follow
  bool leading_zero = true;       ///< 0.5, not .5
  bool comma = false;             ///< a comma stands for the point
  std::uint8_t decimals = 0;      ///< never fewer than these
  std::uint8_t whole_digits = 0;  ///< 007.5 has three: padded to as many; 0 where it was not padded
  friend bool operator==(const NumberStyle&, const NumberStyle&) = default;
};

/// A number at the beginning of a text.
struct ScannedNumber {
  Decimal number;
  NumberStyle style;
  std::size_t length = 0;  ///< bytes it takes, blanks inside it included
};

inline constexpr int kMostDigits = 18;  ///< so that a mantissa fits 64 bits
inline constexpr int kMostDecimals = 12;

/// Reads sign, digits, point, digits; blanks and tabs may stand between them, as controls allow. Nothing where no digit
/// comes, or where there are more digits than kMostDigits or decimals than kMostDecimals.
std::optional<ScannedNumber> scan_number(std::string_view text);

/// `value` rounded to the nearest multiple of 10^-decimals, halves away from zero.
inline Decimal rounded(double value, int decimals) {
  const double scaled = value * static_cast<double>(power_of_ten(decimals));
  std::int64_t whole = static_cast<std::int64_t>(scaled);
  const double rest = scaled - static_cast<double>(whole);
  if (rest >= 0.5) ++whole;
  if (rest <= -0.5) --whole;
  return {whole, decimals};
}

/// The sum, exact, with as many decimals as the finer of both.
Decimal sum_of_unlike(Decimal a, Decimal b);
inline Decimal operator+(Decimal a, Decimal b) {
  if (a.decimals == b.decimals) return {a.mantissa + b.mantissa, a.decimals};
  return sum_of_unlike(a, b);
}
inline Decimal operator-(Decimal a, Decimal b) { return a + Decimal{-b.mantissa, b.decimals}; }

/// Appends `number` in `style`: all its decimals but the zeros at their end beyond style.decimals; never an exponent,
/// never a negative zero.
void append_number(std::string& text, Decimal number, const NumberStyle& style);

}  // namespace trunnion
