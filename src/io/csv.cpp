#include "io/csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "error.h"

namespace trunnion {
namespace {

constexpr std::size_t kLongestLine_bytes = std::size_t{1} << 20;
constexpr std::size_t kLongestName_bytes = 200, kMostColumns = 1000;
constexpr double kLargest = 1e15;  ///< what is squared and multiplied later stays finite

std::string shown(std::string_view field) {
  if (field.empty()) return "nothing";
  std::string text = "\"";
  for (const char c : field.substr(0, 40)) text += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? '?' : c;
  return text + (field.size() > 40 ? "…\"" : "\"");
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

std::optional<double> parse_number(std::string_view text) {
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

void append_number(std::string& text, double value) {
  if (value == 0) value = 0;  // no negative zero
  char digits[40];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  text.append(digits, end);
}

CsvReader::CsvReader(std::string_view text, std::string name) : rest_(text), name_(std::move(name)) {
  if (rest_.starts_with("\xFF\xFE") || rest_.starts_with("\xFE\xFF"))
    throw InputError(name_, "UTF-16 found, UTF-8 is wanted");
  if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
  std::string_view line;
  do {
    if (!take_line(line)) throw InputError(name_, "it is empty; a header row and rows of numbers are wanted");
  } while (trimmed(line).empty() || line.front() == '#');
  for (std::size_t from = 0; from <= line.size();) {
    const std::size_t comma = std::min(line.find(',', from), line.size());
    const std::string column(trimmed(line.substr(from, comma - from)));
    if (column.empty())
      throw InputError(name_, line_, "header: column " + std::to_string(header_.size() + 1) + " has no name");
    if (column.size() > kLongestName_bytes)
      throw InputError(name_, line_,
                       "header: a name of " + std::to_string(column.size()) + " bytes found, column names are wanted");
    if (header_.size() == kMostColumns)
      throw InputError(name_, line_, "header: more than " + std::to_string(kMostColumns) + " columns found");
    if (find(column)) throw InputError(name_, line_, "header: column " + column + " occurs twice");
    header_.push_back(column);
    from = comma + 1;
  }
  if (header_.size() == 1 && header_[0].find(';') != std::string::npos)
    throw InputError(name_, line_, "header: semicolons between the columns found, commas are wanted");
}

bool CsvReader::take_line(std::string_view& line) {
  if (rest_.empty()) return false;
  const std::size_t end = std::min(rest_.find('\n'), rest_.size());
  line = rest_.substr(0, end);
  rest_.remove_prefix(std::min(end + 1, rest_.size()));
  if (line.size() > kLongestLine_bytes)
    throw InputError(name_, line_ + 1,
                     "a line of " + std::to_string(line.size()) + " bytes found, no row is that long");
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  ++line_;
  return true;
}

std::optional<std::size_t> CsvReader::find(std::string_view column) const {
  const auto found = std::ranges::find(header_, column);
  if (found == header_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header_.begin());
}

bool CsvReader::next(std::vector<std::string_view>& fields) {
  std::string_view line;
  do {
    if (!take_line(line)) return false;
  } while (line.empty() || line.front() == '#' || trimmed(line).empty());
  row_text_ = line;
  fields.clear();
  const char* from = line.data();
  const char* const end = line.data() + line.size();
  for (;;) {
    const char* comma = std::find(from, end, ',');
    fields.push_back(trimmed({from, static_cast<std::size_t>(comma - from)}));
    if (comma == end) break;
    from = comma + 1;
  }
  if (fields.size() != header_.size())
    throw InputError(name_, line_,
                     std::to_string(fields.size()) + " fields found, the header has " + std::to_string(header_.size()));
  return true;
}

double CsvReader::number(std::string_view field, std::size_t column) const {
  const std::optional<double> value = parse_number(field);
  if (value && std::abs(*value) <= kLargest) return *value;
  throw InputError(name_, line_,
                   header_[column] + ": " + shown(field) +
                       (value ? " found, a number within 1e15 is wanted" : " found, a finite number is wanted"));
}

}  // namespace trunnion
