#include "history/date.h"

#include <charconv>
#include <chrono>

namespace trunnion {
namespace {

constexpr std::string_view kPattern = "dddd-dd-ddTdd:dd:ddZ";

int number(std::string_view text, std::size_t from, std::size_t count) {
  int value = 0;
  std::from_chars(text.data() + from, text.data() + from + count, value);
  return value;
}

std::chrono::year_month_day day(std::string_view date) {
  return std::chrono::year(number(date, 0, 4)) / number(date, 5, 2) / number(date, 8, 2);
}

}  // namespace

std::optional<std::string> normal_date(std::string_view text) {
  std::string date(text);
  if (date.size() == 10) date += "T00:00:00Z";
  if (date.size() != kPattern.size()) return std::nullopt;
  for (std::size_t k = 0; k < date.size(); ++k)
    if (kPattern[k] == 'd' ? date[k] < '0' || date[k] > '9' : date[k] != kPattern[k]) return std::nullopt;
  if (!day(date).ok() || number(date, 11, 2) > 23 || number(date, 14, 2) > 59 || number(date, 17, 2) > 59)
    return std::nullopt;
  return date;
}

double days_of(std::string_view date) {
  const std::chrono::sys_days midnight{day(date)};
  return static_cast<double>(midnight.time_since_epoch().count()) +
         (number(date, 11, 2) * 3600 + number(date, 14, 2) * 60 + number(date, 17, 2)) / 86400.0;
}

std::string short_date(const std::string& date) { return date.ends_with("T00:00:00Z") ? date.substr(0, 10) : date; }

}  // namespace trunnion
