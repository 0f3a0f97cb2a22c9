#include "postproc/dialect.h"

#include <algorithm>
#include <cctype>

#include "error.h"
#include "postproc/block.h"
#include "postproc/dialects/dialects.h"

namespace trunnion {
namespace {

const Dialect kDialects[] = {
    {"linuxcnc", {}, linuxcnc_scanner, false, "linuxcnc"},
    {"fanuc",
     {.semicolon_ends_block = true, .point_always = true, .feed_over_all_axes = true},
     fanuc_scanner,
     true,
     "fanuc-30i",
     ".nc"},
    {"sinumerik",
     {.comment_open = "; ", .comment_close = "", .direction = {"A3=", "B3=", "C3="}},
     sinumerik_scanner,
     true,
     "sinumerik-840d",
     ".mpf"},
    {"heidenhain",
     {.comment_open = "; ",
      .comment_close = "",
      .line_code = "L",
      .function_in_every_block = true,
      .sign_always = true,
      .time_in_seconds = true,
      .direction = {"TX", "TY", "TZ"}},
     heidenhain_scanner,
     true,
     "heidenhain",
     ".h"},
};

std::string upper_case(std::string_view text) {
  std::string upper(text);
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return upper;
}

/// A line without blanks and tape marks before and behind.
std::string_view bare(std::string_view line) {
  constexpr std::string_view blanks(" \t\r\n\0\x7f", 6);
  const std::size_t first = line.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return line.substr(first, line.find_last_not_of(blanks) + 1 - first);
}

/// A text without what no control reads: ; and (...) but where they belong to a call, as in MSG("...").
std::string without_comments(std::string_view text) {
  std::string told;
  bool bracket = false, line = false;
  for (const char c : text) {
    if (c == '\n') bracket = line = false;
    const bool call = !told.empty() && std::isalpha(static_cast<unsigned char>(told.back())) != 0;
    if (!line && c == '(' && !call) bracket = true;
    if (c == ';') line = true;
    if (!bracket && !line) told += c;
    if (c == ')') bracket = false;
  }
  return told;
}

/// Whether a comment may not stand before this line: it begins the program, or names it.
bool opens_program(const Dialect& dialect, std::string_view line) {
  const std::string text = upper_case(line.substr(0, 64));
  if (dialect.text.function_in_every_block) return text.find("BEGIN PGM") != std::string::npos;
  if (text[0] == '%') return true;
  if (dialect.name == "sinumerik") return text.starts_with(";$PATH") || text.starts_with("PROC ");
  return text[0] == 'O' || text[0] == ':' || text[0] == '<';
}

}  // namespace

const Dialect& dialect(std::string_view name) {
  for (const Dialect& one : kDialects)
    if (one.name == name) return one;
  std::string names;
  for (const std::string& one : dialect_names()) names += (names.empty() ? "" : ", ") + one;
  throw UsageError("dialect " + std::string(name) + ": wanted one of " + names);
}

const std::vector<std::string>& dialect_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Dialect& one : kDialects) all.emplace_back(one.name);
    return all;
  }();
  return names;
}

std::string_view assumption_text(Assumption assumption) {
  switch (assumption) {
    case Assumption::feed_in_tenths_of_inch:
      return "F of this program in inches is taken for tenths of an inch a minute; look at the feed of a block that "
             "was "
             "divided";
    case Assumption::great_circle:
      return "the tool axis is taken to turn in one plane at one rate between two directions (ORIVECT, PATHCTRL "
             "VECTOR); "
             "run a long turn in the air, or post shorter moves";
    case Assumption::feed_over_all_axes:
      return "F is taken to run over mm and degrees alike without tool-centre-point control; look at the feed of a "
             "block "
             "that was divided";
    case Assumption::offset_without_words:
      return "G58 and G59 without axis words are taken for work offsets; use G54 to G57 where they are shifts";
    case Assumption::time_of_one_block:
      return "FT is taken to hold for its block only, in seconds; run the first such block in the air";
    case Assumption::shared_block_numbers:
      return "blocks that were inserted share the number of the one they divide; let the control renumber if it "
             "refuses "
             "them";
    case Assumption::high_speed_by_number:
      return "G5 P10000 and the like are taken for a way of running that leaves the path as it is; correct the program "
             "without them where they are not";
  }
  return "";
}

std::string_view told_dialect(std::string_view head) {
  const std::string text = without_comments(upper_case(head));
  const auto holds = [&](std::string_view sign) { return text.find(sign) != std::string::npos; };
  if (holds("BEGIN PGM")) return "heidenhain";
  for (const std::string_view sign :
       {"TRAORI", "TRAFOOF", "A3=", "MSG(\"", "CYCLE800", "CYCLE832", "=AC(", "=IC(", "=DC("})
    if (holds(sign)) return "sinumerik";
  for (const std::string_view sign : {"G43.4", "G43.5", "G68.2", "G53.1", "G05.1", "G5.1 Q"})
    if (holds(sign)) return "fanuc";
  return "";
}

std::size_t header_place(const Dialect& dialect, std::string_view text) {
  std::size_t place = 0;
  if (text.starts_with(kByteOrderMark)) place = kByteOrderMark.size();
  for (std::size_t at = place; at < text.size();) {
    const std::size_t length = line_length(text.substr(at));
    const std::string_view line = bare(text.substr(at, length));
    at += length;
    if (line.empty()) continue;
    if (!opens_program(dialect, line)) break;
    place = at;
    if (line[0] != '%') break;
  }
  return place;
}

}  // namespace trunnion
