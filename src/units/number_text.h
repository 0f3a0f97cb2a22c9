#pragma once

#include <algorithm>
#include <charconv>
#include <clocale>
#include <cmath>
#include <cstdio>
#include <string>

namespace trunnion {

/// printf-style, in the "C" locale whatever the program that links this has set: with a decimal point.
template <class... Values>
std::string printed(const char* format, Values... values) {
  static const locale_t c_locale = newlocale(LC_ALL_MASK, "C", nullptr);
  const locale_t before = uselocale(c_locale);
  std::string text(128, '\0');
  const int length = std::snprintf(text.data(), text.size(), format, values...);
  const auto wanted = static_cast<std::size_t>(std::max(0, length));
  const bool cut = wanted >= text.size();
  text.resize(wanted);
  if (cut) std::snprintf(text.data(), wanted + 1, format, values...);
  uselocale(before);
  return text;
}

/// The same for one number.
inline std::string formatted(const char* format, double value) { return printed(format, value); }

/// Decimals that show a standard uncertainty to its second significant digit, 0 … 6; 2 where there is none.
inline int decimals_of(double std) {
  return std > 0 && std::isfinite(std) ? std::clamp(1 - static_cast<int>(std::floor(std::log10(std))), 0, 6) : 2;
}

/// With that many decimals; what rounds to nothing has no sign.
inline std::string fixed_text(double value, int decimals) {
  char text[400];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, decimals).ptr;
  const std::string found(text, end);
  return found[0] == '-' && found.find_first_not_of("-0.") == std::string::npos ? found.substr(1) : found;
}

/// A value with its standard uncertainty, both to the uncertainty's second significant digit: "-12.34 +- 0.21".
inline std::string with_uncertainty(double value, double std) {
  const int decimals = decimals_of(std);
  return fixed_text(value, decimals) + " +- " + fixed_text(std, decimals);
}

/// A probability that noise alone would give as much. Far below what a double's tails are good for, only that it is.
inline std::string p_value_text(double p) { return p < 1e-16 ? "<1e-16" : formatted("%.1e", p); }

}  // namespace trunnion
