#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "postproc/motion.h"

namespace trunnion {

inline constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";  ///< with which a UTF-8 text may begin

/// How a dialect writes what a correction adds to a program.
struct DialectText {
  std::string_view comment_open = "(", comment_close = ")";
  std::string_view line_code = "G1";                ///< a straight move at feed
  bool semicolon_ends_block = false;                ///< where a block has one, so has what is inserted
  bool function_in_every_block = false;             ///< no block moves without L or C, and it bears a number (Klartext)
  bool sign_always = false;                         ///< X+1.5
  bool point_always = false;                        ///< X1. where whole numbers may be increments
  bool time_in_seconds = false;                     ///< a block's time is FT, in seconds; else G93 and its reciprocal
  bool feed_over_all_axes = false;                  ///< without tool-centre-point control F runs over mm and deg alike
  std::string_view direction[3] = {"I", "J", "K"};  ///< the words of a tool axis told as a vector
};

/// A language of programs: how it is read and written, and whose it is.
struct Dialect {
  std::string_view name;
  DialectText text;
  std::unique_ptr<ProgramScanner> (*scanner)(const ScanSettings&);
  /// Whether its programs say where tool-centre-point control is on: then it is off at their begin.
  bool says_tcp = false;
  std::string_view controller;       ///< of the machine file, whose programs are these
  std::string_view suffix = ".ngc";  ///< of its programs' files
};

/// Throws UsageError for a name that is none.
const Dialect& dialect(std::string_view name);
/// The dialects that can be corrected.
const std::vector<std::string>& dialect_names();

/// What is taken for granted of a control, nobody having confirmed it, and what to do about it.
std::string_view assumption_text(Assumption assumption);

/// What the first lines of a program say about its dialect, where that is unmistakable: "" where nothing does.
std::string_view told_dialect(std::string_view head);

/// Where the header comment goes: behind a first line that is a tape's %, and the program's name behind it.
std::size_t header_place(const Dialect& dialect, std::string_view text);

}  // namespace trunnion
