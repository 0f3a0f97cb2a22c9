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

/// The same for what nearly every number is: sign, digits, point, digits, up to kMostDigits - 1 of them. Says where it
/// ends; nullptr for any other, and what was said then means nothing.
inline const char* scan_plain_number(const char* at, const char* end, Decimal& number, NumberStyle& style) {
  const bool negative = at != end && *at == '-';
  const bool plus = at != end && *at == '+';
  if (negative || plus) ++at;
  std::uint64_t mantissa = 0;
  const char* const whole = at;
  for (unsigned digit; at != end && (digit = static_cast<unsigned>(*at - '0')) < 10; ++at)
    mantissa = 10 * mantissa + digit;
  const auto whole_digits = at - whole;
  std::ptrdiff_t decimals = 0;
  const bool point = at != end && *at == '.';
  // More digits than these could overflow.
  if (whole_digits >= kMostDigits) return nullptr;
  if (point) {
    const char* const behind = ++at;
    const char* const last = end - at > kMostDecimals ? at + kMostDecimals + 1 : end;
    std::uint64_t fraction = 0;
    for (unsigned digit; at != last && (digit = static_cast<unsigned>(*at - '0')) < 10; ++at)
      fraction = 10 * fraction + digit;
    decimals = at - behind;
    if (decimals > kMostDecimals || whole_digits + decimals >= kMostDigits) return nullptr;
    mantissa = mantissa * static_cast<std::uint64_t>(power_of_ten(static_cast<int>(decimals))) + fraction;
  }
  if (whole_digits + decimals == 0) return nullptr;
  // Digits may go on behind blanks.
  if (at != end && (*at == ' ' || *at == '\t')) {
    const char* next = at;
    while (next != end && (*next == ' ' || *next == '\t')) ++next;
    if (next != end && (static_cast<unsigned>(*next - '0') < 10 || (*next == '.' && !point))) return nullptr;
  }
  number.mantissa = negative ? -static_cast<std::int64_t>(mantissa) : static_cast<std::int64_t>(mantissa);
  number.decimals = static_cast<int>(decimals);
  style.plus = plus;
  style.point = point;
  style.leading_zero = whole_digits > 0;
  style.comma = false;
  style.decimals = static_cast<std::uint8_t>(decimals);
  style.whole_digits = static_cast<std::uint8_t>(whole_digits > 1 && *whole == '0' ? whole_digits : 0);
  return at;
}

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

inline bool same_value(Decimal a, Decimal b) {
  return a.decimals == b.decimals ? a.mantissa == b.mantissa : (a - b).mantissa == 0;
}

/// The longest text of a number: digits, a sign and a point, padding of as many as were read.
inline constexpr std::size_t kLongestNumber = 48;

/// Writes `number` in `style`: all its decimals but the zeros at their end beyond style.decimals; never an exponent,
/// never a negative zero. `text` has kLongestNumber bytes, all of which may be written; comes back behind the number.
char* write_number(char* text, Decimal number, const NumberStyle& style);

/// The same at the end of a text.
void append_number(std::string& text, Decimal number, const NumberStyle& style);

/// `value` with so many decimals at most, for messages.
std::string text_of(double value, int decimals);

}  // namespace trunnion
