#include "postproc/number.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace trunnion {
namespace {

constexpr std::array<std::int64_t, 19> kPowers = [] {
  std::array<std::int64_t, 19> powers{};
  std::int64_t power = 1;
  for (std::size_t i = 0; i < powers.size(); ++i, power *= i < powers.size() ? 10 : 1) powers[i] = power;
  return powers;
}();

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_blank(char c) { return c == ' ' || c == '\t'; }

/// Both with the decimals of the finer.
std::pair<Decimal, Decimal> aligned(Decimal a, Decimal b) {
  const int decimals = std::max(a.decimals, b.decimals);
  a.mantissa *= power_of_ten(decimals - a.decimals);
  b.mantissa *= power_of_ten(decimals - b.decimals);
  a.decimals = b.decimals = decimals;
  return {a, b};
}

}  // namespace

std::int64_t power_of_ten(int n) {
  assert(n >= 0 && n < 19);
  return kPowers[static_cast<std::size_t>(n)];
}

double Decimal::value() const { return static_cast<double>(mantissa) / static_cast<double>(power_of_ten(decimals)); }

std::optional<ScannedNumber> scan_number(std::string_view text) {
  const char* at = text.data();
  const char* const end = at + text.size();
  ScannedNumber scanned;
  bool negative = false;
  if (at != end && (*at == '+' || *at == '-')) {
    negative = *at == '-';
    scanned.style.plus = *at == '+';
    ++at;
  }
  std::int64_t mantissa = 0;
  int whole = 0, significant = 0, decimals = 0;
  bool point = false, begins_with_zero = false;
  const char* after = at;  // behind the last byte that belongs to the number
  for (;; ++at) {
    while (at != end && is_blank(*at)) ++at;
    if (at == end) break;
    if (is_digit(*at)) {
      if (whole == 0 && !point) begins_with_zero = *at == '0';
      mantissa = 10 * mantissa + (*at - '0');
      significant += mantissa != 0;
      if (significant > kMostDigits) return std::nullopt;
      ++(point ? decimals : whole);
    } else if (*at == '.' && !point) {
      point = true;
    } else {
      break;
    }
    after = at + 1;
  }
  if (whole + decimals == 0 || whole > kMostDigits || decimals > kMostDecimals) return std::nullopt;
  scanned.style.leading_zero = whole > 0;
  if (begins_with_zero && whole > 1) scanned.style.whole_digits = static_cast<std::uint8_t>(whole);
  scanned.number = {negative ? -mantissa : mantissa, decimals};
  scanned.style.point = point;
  scanned.style.decimals = static_cast<std::uint8_t>(decimals);
  scanned.length = static_cast<std::size_t>(after - text.data());
  return scanned;
}

Decimal rounded(double value, int decimals) {
  return {static_cast<std::int64_t>(std::llround(value * static_cast<double>(power_of_ten(decimals)))), decimals};
}

Decimal operator+(Decimal a, Decimal b) {
  const auto [x, y] = aligned(a, b);
  return {x.mantissa + y.mantissa, x.decimals};
}

Decimal operator-(Decimal a, Decimal b) { return a + Decimal{-b.mantissa, b.decimals}; }

void append_number(std::string& text, Decimal number, const NumberStyle& style) {
  std::uint64_t left = number.mantissa < 0 ? 0 - static_cast<std::uint64_t>(number.mantissa)
                                           : static_cast<std::uint64_t>(number.mantissa);
  int decimals = number.decimals;
  while (decimals > style.decimals && left % 10 == 0) left /= 10, --decimals;

  std::array<char, 48> buffer;
  char* const end = buffer.data() + buffer.size();
  char* at = end;
  const bool zero = left == 0;
  for (int i = 0; i < decimals; ++i, left /= 10) *--at = static_cast<char>('0' + left % 10);
  if (decimals > 0 || style.point) *--at = '.';
  int whole = 0;
  for (; left != 0; left /= 10, ++whole) *--at = static_cast<char>('0' + left % 10);
  const int wanted = std::max<int>(style.whole_digits, style.leading_zero || decimals == 0 ? 1 : 0);
  for (; whole < wanted; ++whole) *--at = '0';
  if (number.mantissa < 0 && !zero) *--at = '-';
  if (number.mantissa >= 0 && style.plus) *--at = '+';
  text.append(at, end);
}

}  // namespace trunnion
