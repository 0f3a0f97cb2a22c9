#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace trunnion {

/// `2026-03-01` or `2026-03-01T14:30:00Z` (UTC) in the form in which a history keeps it: the second, as text that sorts
/// by time. Empty for anything else, or a day that no calendar has.
std::optional<std::string> normal_date(std::string_view text);

/// Days since 1970-01-01T00:00:00Z of what normal_date() gave.
double days_of(std::string_view date);

/// `2026-03-01` where the time of day is midnight, else all of it.
std::string short_date(const std::string& date);

}  // namespace trunnion
