#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace trunnion {

/// A number of an NC word as its digits say it: value = mantissa 10^-decimals. Nothing is lost on the way from text to
/// text.
struct Decimal {
  std::int64_t mantissa = 0;
  int decimals = 0;

  double value() const;
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

/// 10^n for n = 0 ... 18.
std::int64_t power_of_ten(int n);

/// `value` rounded to the nearest multiple of 10^-decimals, halves away from zero.
Decimal rounded(double value, int decimals);

/// The sum, exact, with as many decimals as the finer of both.
Decimal operator+(Decimal a, Decimal b);
Decimal operator-(Decimal a, Decimal b);

/// Appends `number` in `style`: all its decimals but the zeros at their end beyond style.decimals; never an exponent,
/// never a negative zero.
void append_number(std::string& text, Decimal number, const NumberStyle& style);

}  // namespace trunnion
