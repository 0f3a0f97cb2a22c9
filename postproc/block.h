#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "postproc/number.h"

namespace trunnion {

enum class TokenKind : std::uint8_t {
  word,          ///< a letter and a number: X-10.5, G1, N100; with names also X=10.5, X=IC(2), A3=0.5, CR=4
  expression,    ///< a letter or a name and what is not a plain number: X#1, X[1+2], F<speed>, X=R1
  parameter,     ///< #1=2, $AA_IW[X]=1, an assignment, to its end
  comment,       ///< (...) or ; to the end of the line
  name,          ///< TRAORI, CYCLE800(...)
  label,         ///< START:
  percent,       ///< % and what follows it on its line
  block_delete,  ///< / or /1 ... /9
  other,         ///< bytes that mean nothing here
  line_end,      ///< LF, CR LF, or LF CR CR of a punched tape; also the blanks before it, and a ; that ends a block
};

/// How the number of a word counts where the word itself says so.
enum class Counting : std::uint8_t { modal, absolute, incremental, shortest, one_way };

/// A piece of a line. Tokens follow one another without gap from the line's first byte to its last: the blanks (and
/// tape marks: NUL, DEL, lone CR) before a piece belong to it.
struct Token {
  TokenKind kind = TokenKind::other;
  char letter = 0;  ///< of a word or an expression, upper case; 0 where a name stands in its place
  Counting counting = Counting::modal;
  NumberStyle style;             ///< of a word
  std::uint32_t begin = 0;       ///< first byte, blanks before it included
  std::uint32_t text = 0;        ///< first byte that is not such a blank
  std::uint32_t name_end = 0;    ///< behind the name of a word, an expression, a name or a label
  std::uint32_t number = 0;      ///< first byte of a word's number
  std::uint32_t number_end = 0;  ///< behind it
  std::uint32_t end = 0;         ///< behind the last byte
  Decimal value;                 ///< of a word
};

/// What differs among the controls that read letters and numbers.
struct IsoSyntax {
  bool bracket_comments = true;       ///< (...) is a comment
  bool semicolon_ends_block = false;  ///< ; ends a block instead of beginning a comment
  bool names = false;                 ///< words of several letters, =, calls and labels
};

/// Takes lines of the letter-and-number kind (RS274, ISO 6983) apart. It keeps its memory from line to line.
class IsoTokenizer {
 public:
  explicit IsoTokenizer(IsoSyntax syntax = {}) : syntax_(syntax) {}

  /// The tokens of `line`, its line end included; valid until the next call. Throws nothing: what is not understood is
  /// `other`.
  std::span<const Token> operator()(std::string_view line);

 private:
  std::size_t plain(std::string_view line, std::size_t at, std::size_t newline, Token& token) const;
  std::size_t named(std::string_view line, std::size_t at, std::size_t newline, Token& token) const;
  std::size_t assigned(std::string_view line, std::size_t at, std::size_t newline, Token& token) const;

  IsoSyntax syntax_;
  std::vector<Token> tokens_;
};

/// Length of the first line of `text`, its line end (LF, CR LF, LF CR CR) included; all of it where none comes.
std::size_t line_length(std::string_view text);

/// The line end that `line` carries: "\n", "\r\n", "\n\r\r", or nothing.
std::string_view line_end(std::string_view line);

}  // namespace trunnion
