#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "postproc/number.h"

namespace trunnion {

enum class TokenKind : std::uint8_t {
  word,          ///< a letter and a number: X-10.5, G1, N100
  expression,    ///< a letter and what is not a plain number: X#1, X[1+2], F<speed>, X=...
  parameter,     ///< #1=2, an assignment, to its end
  comment,       ///< (...) or ; to the end of the line
  percent,       ///< % and what follows it on its line
  block_delete,  ///< / or /1 ... /9
  other,         ///< bytes that mean nothing here
  line_end,      ///< LF, CR LF, or LF CR CR of a punched tape; also the blanks before it
};

/// A piece of a line. Tokens follow one another without gap from the line's first byte to its last: the blanks (and
/// tape marks: NUL, DEL, lone CR) before a piece belong to it.
struct Token {
  TokenKind kind = TokenKind::other;
  char letter = 0;          ///< of a word or an expression, upper case
  std::uint32_t begin = 0;  ///< first byte, blanks before it included
  std::uint32_t text = 0;   ///< first byte that is not such a blank
  std::uint32_t end = 0;    ///< behind the last byte
  Decimal number;           ///< of a word
  NumberStyle style;
};

/// Takes lines of the letter-and-number kind (RS274, ISO 6983) apart. It keeps its memory from line to line.
class IsoTokenizer {
 public:
  /// The tokens of `line`, its line end included; valid until the next call. Throws nothing: what is not understood is
  /// `other`.
  std::span<const Token> operator()(std::string_view line);

 private:
  std::vector<Token> tokens_;
};

/// Length of the first line of `text`, its line end (LF, CR LF, LF CR CR) included; all of it where none comes.
std::size_t line_length(std::string_view text);

/// The line end that `line` carries: "\n", "\r\n", "\n\r\r", or nothing.
std::string_view line_end(std::string_view line);

}  // namespace trunnion
