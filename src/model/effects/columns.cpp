#include "model/effects/columns.h"

#include <algorithm>

namespace trunnion {
namespace {

std::string small_letters(std::string_view text) {
  std::string small(text);
  for (char& c : small)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return small;
}

}  // namespace

bool is_temperature(std::string_view column) {
  return small_letters(column).find("temp") != std::string::npos || column.ends_with("_C") || column.ends_with("_degC");
}

double zero_of_column(std::string_view column) {
  if (column == "A_dir" || column == "B_dir" || column == "C_dir") return 1;
  return is_temperature(column) ? 20 : 0;
}

double beyond_zero(const Situation& s, std::string_view column) {
  const std::optional<double> value = s.covariate(column);
  return value ? *value - zero_of_column(column) : 0;
}

std::optional<ColumnRange> spread(const CandidateScope& scope, std::string_view column) {
  if (std::ranges::find(scope.columns, column) == scope.columns.end()) return std::nullopt;
  std::optional<ColumnRange> found;
  for (const Situation& s : scope.readings) {
    const std::optional<double> value = s.covariate(column);
    if (!value) continue;
    if (!found) found = ColumnRange{*value, *value};
    found->low = std::min(found->low, *value);
    found->high = std::max(found->high, *value);
  }
  return found && found->width() > 0 ? found : std::nullopt;
}

std::vector<std::string> temperature_columns(const CandidateScope& scope) {
  std::vector<std::string> found;
  for (const std::string& column : scope.columns)
    if (is_temperature(column) && spread(scope, column))
      found.insert(column == "temperature_C" ? found.begin() : found.end(), column);
  return found;
}

std::vector<std::string> columns_named(const CandidateScope& scope, const std::vector<std::string_view>& words) {
  std::vector<std::string> found;
  for (const std::string& column : scope.columns) {
    const std::string small = small_letters(column);
    const bool named =
        std::ranges::any_of(words, [&](std::string_view word) { return small.find(word) != std::string::npos; });
    if (named && spread(scope, column)) found.push_back(column);
  }
  return found;
}

bool has_kind(const CandidateScope& scope, ReadingKind kind) {
  return std::ranges::any_of(scope.readings, [&](const Situation& s) { return s.reading == kind; });
}

}  // namespace trunnion
