#include "compensation/controllers/fanuc_files.h"

#include <cmath>
#include <set>

#include "compensation/number_text.h"
#include "error.h"

namespace trunnion::fanuc {
namespace {

constexpr int kPlaceDecimals = 4;
constexpr double kLargestPitch = 7;
constexpr double kLargestMagnification = 100;
constexpr std::string_view kProgramHead = "O9000", kSetting = "G10L52", kSettingEnd = "G11", kProgramEnd = "M30";

std::string value_text(const Entry& entry, Emission emission) {
  if (!emission.quantised) return shortest_text(entry.value);
  return fixed_text(entry.value, entry.real ? kPlaceDecimals : 0);
}

/// Numbers that count points or pulses.
bool is_whole(long number) {
  return (number >= 3600 && number <= 3627 && number != 3624 && number != 3625) || number == 19680 ||
         (number >= kPitchBase && number < 19000);
}

/// A file line by line, as strictly as the control reads it.
class Lines {
 public:
  explicit Lines(const TableFile& file) : file_(file), rest_(file.text) {}

  /// The next line without its end. Throws at the end of the file.
  std::string_view next() {
    ++line_;
    if (rest_.empty()) wrong("the file ends, % is wanted");
    const std::size_t end = rest_.find('\n');
    if (end == std::string_view::npos) wrong("the last line has no end, LF is wanted");
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(end + 1);
    if (line.ends_with('\r')) wrong("the line ends with CR LF, LF alone is wanted");
    check_letters(line);
    return line;
  }

  void percent_first() {
    if (const std::string_view line = next(); line != "%")
      wrong(shown(line) + " found, % alone is wanted on the first line");
  }
  void nothing_left() {
    ++line_;
    if (!rest_.empty()) wrong("text behind the % at the end");
  }
  [[noreturn]] void wrong(const std::string& text) const { throw InputError(file_.name, line_, text); }
  std::size_t line() const { return line_; }
  static std::string shown(std::string_view line) { return '"' + std::string(line.substr(0, 60)) + '"'; }

 private:
  void check_letters(std::string_view line) const {
    if (line.empty()) wrong("an empty line");
    if (line.size() > 1 && line.find('%') != std::string_view::npos)
      wrong(shown(line) + ": % stands alone on its line");
    bool comment = false;
    for (const char letter : line) {
      if (letter >= 'a' && letter <= 'z') wrong(shown(line) + ": small letters, capitals are wanted");
      if (letter == '(') comment = true;
      if (letter == ')') comment = false;
      const bool known = (letter >= 'A' && letter <= 'Z') || (letter >= '0' && letter <= '9') ||
                         std::string_view("+-.;%()").find(letter) != std::string_view::npos;
      const bool in_comment = comment && std::string_view(" ,/=:#*?_").find(letter) != std::string_view::npos;
      if (!known && !in_comment)
        wrong("character number " + std::to_string(static_cast<unsigned char>(letter)) +
              " found, capital letters, digits and + - . are wanted");
    }
  }

  const TableFile& file_;
  std::string_view rest_;
  std::size_t line_ = 0;
};

/// One block's words, addresses in the order of `order`; those of `optional` may be missing.
Entry block_of(std::string_view line, std::string_view order, char optional, bool exponents, const Lines& lines) {
  Entry entry;
  std::size_t at = 0;
  const std::string_view digits = exponents ? "+-.0123456789e" : "+-.0123456789";
  for (const char address : order) {
    if (at >= line.size() || line[at] != address) {
      if (address == optional) continue;
      lines.wrong(Lines::shown(line) + ": " + address + " and a number are wanted, in the order " + std::string(order));
    }
    const std::size_t end = std::min(line.find_first_not_of(digits, at + 1), line.size());
    const auto value = number_from(line.substr(at + 1, end - at - 1));
    if (!value) lines.wrong(std::string("address ") + address + ": a number is wanted behind it");
    const bool is_number = address == 'N', is_value = address == order.back();
    if (is_value) {
      entry.value = *value;
    } else if (is_number ? !(*value >= 1 && *value < 100000) : !(*value >= 1 && *value <= 32)) {
      lines.wrong(std::string("address ") + address + ": " +
                  (is_number ? "the number of a parameter" : "the number of an axis, 1 to 32,") + " is wanted");
    } else {
      (is_number ? entry.number : entry.axis) = std::lround(*value);
    }
    at = end;
  }
  if (at != line.size()) lines.wrong(Lines::shown(line) + ": more than " + std::string(order));
  return entry;
}

/// What the control takes as values.
void check_value(const Entry& entry, std::set<std::pair<long, long>>& seen, const Lines& lines) {
  const std::string name = "N" + std::to_string(entry.number);
  if (!seen.emplace(entry.number, entry.axis).second) lines.wrong(name + " stands twice");
  if (is_whole(entry.number) && entry.value != std::round(entry.value))
    lines.wrong(name + ": " + shortest_text(entry.value) + " found, a whole number is wanted");
  const bool pitch = entry.number >= kPitchBase && entry.number < 19000;
  if (pitch && std::abs(entry.value) > kLargestPitch)
    lines.wrong(name + ": " + shortest_text(entry.value) + " found, a pitch error from -7 to 7 is wanted");
  if (entry.number == 3623 && !(entry.value >= 1 && entry.value <= kLargestMagnification))
    lines.wrong(name + ": " + shortest_text(entry.value) + " found, a magnification from 1 to 100 is wanted");
  if ((entry.number >= 3620 && entry.number <= 3627) != (entry.axis != 0))
    lines.wrong(name + (entry.axis != 0 ? ": no parameter of an axis" : ": an axis is wanted"));
}

}  // namespace

double detection_unit_deg(const CompensationTask& task) { return task.profile.number("detection_unit_deg"); }

TableFile parameter_file(const std::vector<Entry>& entries, Emission emission) {
  std::string text = "%\n";
  for (const Entry& entry : entries)
    text += "N" + std::to_string(entry.number) + (entry.axis == 0 ? "" : "A" + std::to_string(entry.axis)) + "P" +
            value_text(entry, emission) + ";\n";
  return {emission.quantised ? kParameterFile : kUnroundedFile, text + "%\n"};
}

TableFile program_file(const std::vector<Entry>& entries, const std::string& comment) {
  std::string text = "%\n" + std::string(kProgramHead) + "(";
  for (const char letter : comment) {
    const char large = letter >= 'a' && letter <= 'z' ? static_cast<char>(letter - 'a' + 'A') : letter;
    const bool known = (large >= 'A' && large <= 'Z') || (large >= '0' && large <= '9') ||
                       std::string_view(" ,.-+").find(large) != std::string_view::npos;
    text += known ? large : ' ';
  }
  text += ")\n" + std::string(kSetting) + "\n";
  for (const Entry& entry : entries)
    text += "N" + std::to_string(entry.number) + (entry.axis == 0 ? "" : "P" + std::to_string(entry.axis)) + "R" +
            value_text(entry, {}) + "\n";
  return {kProgramFile, text + std::string(kSettingEnd) + "\n" + std::string(kProgramEnd) + "\n%\n"};
}

std::vector<Entry> read_parameters(const TableFile& file) {
  std::vector<Entry> entries;
  std::set<std::pair<long, long>> seen;
  Lines lines(file);
  if (file.name == kUnroundedFile) {
    for (const std::string_view line : lines_of(file.text))
      if (line != "%") entries.push_back(block_of(line.substr(0, line.find(';')), "NAP", 'A', true, lines));
    return entries;
  }
  lines.percent_first();
  for (std::string_view line = lines.next(); line != "%"; line = lines.next()) {
    if (line.back() != ';') lines.wrong(Lines::shown(line) + ": a block ends with ;");
    line.remove_suffix(1);
    entries.push_back(block_of(line, "NAP", 'A', false, lines));
    check_value(entries.back(), seen, lines);
  }
  lines.nothing_left();
  return entries;
}

std::vector<Entry> read_program(const TableFile& file) {
  std::vector<Entry> entries;
  std::set<std::pair<long, long>> seen;
  Lines lines(file);
  lines.percent_first();
  const auto wanted = [&](std::string_view line, std::string_view word) {
    if (line.substr(0, line.find('(')) != word)
      lines.wrong(Lines::shown(line) + " found, " + std::string(word) + " is wanted");
  };
  wanted(lines.next(), kProgramHead);
  wanted(lines.next(), kSetting);
  for (std::string_view line = lines.next(); line != kSettingEnd; line = lines.next()) {
    entries.push_back(block_of(line, "NPR", 'P', false, lines));
    check_value(entries.back(), seen, lines);
  }
  wanted(lines.next(), kProgramEnd);
  wanted(lines.next(), "%");
  lines.nothing_left();
  return entries;
}

}  // namespace trunnion::fanuc
