#include "postproc/number.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>

namespace trunnion {
namespace {

constexpr std::int64_t kMostMantissa = 100'000'000'000'000'000;  // one digit more makes kMostDigits

bool is_figure(char c) { return c >= '0' && c <= '9'; }
bool is_space(char c) { return c == ' ' || c == '\t'; }

constexpr std::array<char, 200> kTwoDigits = [] {
  std::array<char, 200> digits{};
  for (std::size_t i = 0; i < 100; ++i) {
    digits[2 * i] = static_cast<char>('0' + i / 10);
    digits[2 * i + 1] = static_cast<char>('0' + i % 10);
  }
  return digits;
}();

/// Before `at`, the two digits of a number below 100.
char* two_digits(char* at, std::uint64_t number) {
  *--at = kTwoDigits[2 * number + 1];
  *--at = kTwoDigits[2 * number];
  return at;
}

/// Both with the decimals of the finer.
std::pair<Decimal, Decimal> aligned(Decimal a, Decimal b) {
  const int decimals = std::max(a.decimals, b.decimals);
  a.mantissa *= power_of_ten(decimals - a.decimals);
  b.mantissa *= power_of_ten(decimals - b.decimals);
  a.decimals = b.decimals = decimals;
  return {a, b};
}

}  // namespace

std::optional<ScannedNumber> scan_number(std::string_view text) {
  ScannedNumber plain;
  if (const char* behind = scan_plain_number(text.data(), text.data() + text.size(), plain.number, plain.style)) {
    plain.length = static_cast<std::size_t>(behind - text.data());
    return plain;
  }
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
  while (at != end && is_space(*at)) {
    // Controls pass over blanks inside a number.
    while (at != end && is_space(*at)) ++at;
    if (at == end) break;
    if (*at == '.' && !point) {
      point = true;
      ++at;
    } else if (!is_figure(*at)) {
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

Decimal sum_of_unlike(Decimal a, Decimal b) {
  const auto [x, y] = aligned(a, b);
  return {x.mantissa + y.mantissa, x.decimals};
}

namespace {

/// The eight digits of a number below 10^8, the first in the lowest byte: halves, pairs and digits side by side in one
/// word, divided by 100 and by 10 as multiplications that are exact in their range.
std::uint64_t eight_digits(std::uint32_t number) {
  const std::uint64_t halves = number / 10000 | std::uint64_t{number % 10000} << 32;
  const std::uint64_t hundreds = halves * 10486 >> 20 & 0x0000007f0000007f;
  const std::uint64_t pairs = hundreds + ((halves - 100 * hundreds) << 16);
  const std::uint64_t tens = pairs * 103 >> 10 & 0x000f000f000f000f;
  return tens + ((pairs - 10 * tens) << 8);
}

/// The usual number: up to eight digits, some of them decimals, nothing padded. nullptr for any other.
char* write_usual_number(char* text, Decimal number, const NumberStyle& style) {
  const std::uint64_t size = number.mantissa < 0 ? 0 - static_cast<std::uint64_t>(number.mantissa)
                                                 : static_cast<std::uint64_t>(number.mantissa);
  const int decimals = number.decimals;
  if (size >= 100'000'000 || size == 0 || decimals < 1 || decimals > 6 || style.whole_digits != 0 ||
      (decimals > style.decimals && size % 10 == 0))
    return nullptr;
  if (number.mantissa < 0)
    *text++ = '-';
  else if (style.plus)
    *text++ = '+';
  const std::uint64_t digits = eight_digits(static_cast<std::uint32_t>(size));
  const int whole = 8 - decimals;
  const int first = std::min(std::countr_zero(digits) / 8, style.leading_zero ? whole - 1 : whole);
  const std::uint64_t letters = digits + 0x3030303030303030;
  const std::uint64_t front = letters >> 8 * first, back = letters >> 8 * whole;
  std::memcpy(text, &front, 8);
  text += whole - first;
  *text++ = style.comma ? ',' : '.';
  std::memcpy(text, &back, 8);
  return text + decimals;
}

}  // namespace

char* write_number(char* text, Decimal number, const NumberStyle& style) {
  if constexpr (std::endian::native == std::endian::little)
    if (char* const behind = write_usual_number(text, number, style)) return behind;
  std::uint64_t left = number.mantissa < 0 ? 0 - static_cast<std::uint64_t>(number.mantissa)
                                           : static_cast<std::uint64_t>(number.mantissa);
  int decimals = number.decimals;
  while (decimals > style.decimals && left % 10 == 0) left /= 10, --decimals;

  std::array<char, 2 * kLongestNumber> buffer;
  char* const end = buffer.data() + kLongestNumber;
  char* at = end;
  const bool zero = left == 0;
  int i = 0;
  for (; i + 1 < decimals; i += 2, left /= 100) at = two_digits(at, left % 100);
  if (i < decimals) *--at = static_cast<char>('0' + left % 10), left /= 10;
  if (decimals > 0 || style.point) *--at = style.comma ? ',' : '.';
  const char* const point = at;
  for (; left >= 10; left /= 100) at = two_digits(at, left % 100);
  if (left > 0) *--at = static_cast<char>('0' + left);
  if (at != point && *at == '0') ++at;  // the first of two digits
  const int wanted = std::max<int>(style.whole_digits, style.leading_zero || decimals == 0 ? 1 : 0);
  for (auto whole = point - at; whole < wanted; ++whole) *--at = '0';
  if (number.mantissa < 0 && !zero) *--at = '-';
  if (number.mantissa >= 0 && style.plus) *--at = '+';
  std::memcpy(text, at, kLongestNumber);  // of known length
  return text + (end - at);
}

void append_number(std::string& text, Decimal number, const NumberStyle& style) {
  std::array<char, kLongestNumber> buffer;
  text.append(buffer.data(), write_number(buffer.data(), number, style));
}

std::string text_of(double value, int decimals) {
  std::string text;
  append_number(text, rounded(value, decimals), {});
  return text;
}

}  // namespace trunnion
