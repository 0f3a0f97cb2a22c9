#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace trunnion {

/// printf-style, for one number; in the program's "C" locale, so with a decimal point.
inline std::string formatted(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

/// Decimals that show a standard uncertainty to its second significant digit, 0 … 6; 2 where there is none.
inline int decimals_of(double std) {
  return std > 0 && std::isfinite(std) ? std::clamp(1 - static_cast<int>(std::floor(std::log10(std))), 0, 6) : 2;
}

/// With that many decimals; what rounds to nothing has no sign.
inline std::string fixed_text(double value, int decimals) {
  char text[400];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  const std::string found(text);
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
