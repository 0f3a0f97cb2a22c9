#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace trunnion {

/// Walks through comma-separated text: a header row, `#` comment lines and blank lines passed over, LF or CR LF, a byte
/// order mark tolerated. Fields are views into the text.
class CsvReader {
 public:
  /// Reads the header. Throws InputError for an empty text, an unnamed or a repeated column.
  CsvReader(std::string_view text, std::string name);

  const std::vector<std::string>& header() const { return header_; }
  /// Index of a column; empty if there is none.
  std::optional<std::size_t> find(std::string_view column) const;

  /// The next row's fields; false at the end. Throws InputError for a row with another number of fields.
  bool next(std::vector<std::string_view>& fields);
  /// Line of the row last read, from 1, and its text without the line end.
  std::size_t line() const { return line_; }
  std::string_view row_text() const { return row_text_; }

  /// The number in a field of the row last read. Throws InputError naming line and column for anything but one finite
  /// number.
  double number(std::string_view field, std::size_t column) const;
  const std::string& name() const { return name_; }

 private:
  bool take_line(std::string_view& line);
  std::string_view rest_;
  std::string name_;
  std::vector<std::string> header_;
  std::size_t line_ = 0;
  std::string_view row_text_;
};

/// Blanks at both ends taken off.
std::string_view trimmed(std::string_view text);

/// Shortest form that reads back as the same number; -0 is written 0.
void append_number(std::string& text, double value);

/// The finite number that is all of `text`; empty if it is anything else.
std::optional<double> parse_number(std::string_view text);

}  // namespace trunnion
