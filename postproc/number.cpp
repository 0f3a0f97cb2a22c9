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

constexpr std::int64_t kMostMantissa = 100'000'000'000'000'000;  // one digit more makes kMostDigits

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
  int whole = 0, decimals = 0;
  bool point = false;
  const char* first = at;  // of the digits
  // Digits, a point, digits: nearly every number is that.
  const auto digits = [&] {
    const char* const begin = at;
    for (unsigned digit; at != end && (digit = static_cast<unsigned>(*at - '0')) < 10; ++at) {
      if (mantissa >= kMostMantissa) return -1;
      mantissa = 10 * mantissa + digit;
    }
    return static_cast<int>(at - begin);
  };
  if ((whole = digits()) < 0) return std::nullopt;
  if (at != end && *at == '.') {
    point = true;
    ++at;
    if ((decimals = digits()) < 0) return std::nullopt;
  }
  const char* after = at;  // behind the last byte that belongs to the number
  while (at != end && is_blank(*at)) {
    // Controls pass over blanks inside a number.
    while (at != end && is_blank(*at)) ++at;
    if (at == end) break;
    if (*at == '.' && !point) {
      point = true;
      ++at;
    } else if (!is_digit(*at)) {
      break;
    }
    if (whole == 0 && !point) first = at;
    const int more = digits();
    if (more < 0) return std::nullopt;
    (point ? decimals : whole) += more;
    if (!point && at != end && *at == '.') {
      point = true;
      ++at;
      const int further = digits();
      if (further < 0) return std::nullopt;
      decimals += further;
    }
    after = at;
  }
  const bool begins_with_zero = whole > 0 && *first == '0';
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
  if (a.decimals == b.decimals) return {a.mantissa + b.mantissa, a.decimals};
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
  if (decimals > 0 || style.point) *--at = style.comma ? ',' : '.';
  int whole = 0;
  for (; left != 0; left /= 10, ++whole) *--at = static_cast<char>('0' + left % 10);
  const int wanted = std::max<int>(style.whole_digits, style.leading_zero || decimals == 0 ? 1 : 0);
  for (; whole < wanted; ++whole) *--at = '0';
  if (number.mantissa < 0 && !zero) *--at = '-';
  if (number.mantissa >= 0 && style.plus) *--at = '+';
  text.append(at, end);
}

}  // namespace trunnion
