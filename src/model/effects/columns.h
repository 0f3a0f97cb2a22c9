#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/catalogue.h"

namespace trunnion {

/// Whether a column looks like a temperature in degrees Celsius: "temp" in its name, or the ending _C or _degC.
bool is_temperature(std::string_view column);

/// The value of a column at the zero of every effect (CONTRACT): 20 for a temperature, 1 for the sense of a rotary
/// axis, else 0.
double zero_of_column(std::string_view column);

/// How far a column stands from its zero in a situation; 0 where the situation does not know it.
double beyond_zero(const Situation& situation, std::string_view column);

/// Smallest and largest value among the readings of a column that the data carry and that varies; else empty.
struct ColumnRange {
  double low = 0;
  double high = 0;
  double width() const { return high - low; }
};
std::optional<ColumnRange> spread(const CandidateScope& scope, std::string_view column);

/// The carried columns that vary and look like a temperature, temperature_C first.
std::vector<std::string> temperature_columns(const CandidateScope& scope);

/// The carried, varying columns whose name, in small letters, contains one of `words`.
std::vector<std::string> columns_named(const CandidateScope& scope, const std::vector<std::string_view>& words);

/// Whether any reading is of the kind.
bool has_kind(const CandidateScope& scope, ReadingKind kind);

}  // namespace trunnion
