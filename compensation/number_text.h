#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "units/number_text.h"

// Inline: other parts have words of the same names, and parts side by side do not know each other.
namespace trunnion::inline table_text {

/// The shortest text that reads back as `value`, never "-0".
std::string shortest_text(double value);
/// What reading fixed_text(value, decimals) gives.
double rounded(double value, int decimals);

/// The whole of `word` as a finite number, a leading + allowed.
std::optional<double> number_from(std::string_view word);
std::optional<long> integer_from(std::string_view word);

/// The words between blanks and tabs.
std::vector<std::string_view> words_of(std::string_view line);
/// The lines, without their ends (`\n` or `\r\n`).
std::vector<std::string_view> lines_of(std::string_view text);
std::string_view trimmed(std::string_view text);

}  // namespace trunnion::inline table_text
