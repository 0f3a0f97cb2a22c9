#include "postproc/block.h"

#include <cstring>

namespace trunnion {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\0' || c == '\x7f'; }
bool is_letter(char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); }
char upper(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

/// Behind a balanced expression that begins at `at`: brackets may hold anything, outside them a blank, a letter or a
/// comment ends it. A name in <> belongs to it.
std::size_t expression_end(std::string_view line, std::size_t at, std::size_t end) {
  int depth = 0;
  for (bool name = false; at < end; ++at) {
    const char c = line[at];
    if (name) {
      name = c != '>';
    } else if (c == '<') {
      name = true;
    } else if (c == '[') {
      ++depth;
    } else if (c == ']') {
      if (depth > 0) --depth;
    } else if (depth == 0 && (is_blank(c) || is_letter(c) || c == '(' || c == ';')) {
      break;
    }
  }
  return at;
}

}  // namespace

std::size_t line_length(std::string_view text) {
  const void* found = std::memchr(text.data(), '\n', text.size());
  if (found == nullptr) return text.size();
  std::size_t end = static_cast<std::size_t>(static_cast<const char*>(found) - text.data()) + 1;
  const std::string_view rest = text.substr(end);
  if (rest.starts_with("\r\r") && !rest.starts_with("\r\r\n")) end += 2;
  return end;
}

std::string_view line_end(std::string_view line) {
  if (line.ends_with("\n\r\r")) return "\n\r\r";
  if (line.ends_with("\r\n")) return "\r\n";
  return line.ends_with("\n") ? "\n" : "";
}

std::span<const Token> IsoTokenizer::operator()(std::string_view line) {
  tokens_.clear();
  const std::size_t newline = line.ends_with("\n\r\r") ? line.size() - 3
                              : line.ends_with("\n")   ? line.size() - 1
                                                       : line.size();
  std::size_t at = 0;
  while (at < line.size()) {
    Token token;
    token.begin = static_cast<std::uint32_t>(at);
    while (at < newline && is_blank(line[at])) ++at;
    token.text = static_cast<std::uint32_t>(at);
    if (at >= newline) {
      token.kind = TokenKind::line_end;
      at = line.size();
    } else if (const char c = line[at]; is_letter(c)) {
      token.letter = upper(c);
      std::size_t number = at + 1;
      while (number < newline && (line[number] == ' ' || line[number] == '\t')) ++number;
      if (const auto scanned = scan_number(line.substr(number, newline - number))) {
        token.kind = TokenKind::word;
        token.number = scanned->number;
        token.style = scanned->style;
        at = number + scanned->length;
      } else {
        token.kind = TokenKind::expression;
        at = expression_end(line, number, newline);
      }
    } else if (c == '(') {
      token.kind = TokenKind::comment;
      const std::size_t close = line.find(')', at);
      at = close == std::string_view::npos || close >= newline ? newline : close + 1;
      if (line[at - 1] != ')') token.kind = TokenKind::other;
    } else if (c == ';') {
      token.kind = TokenKind::comment;
      at = newline;
    } else if (c == '%') {
      token.kind = TokenKind::percent;
      at = newline;
    } else if (c == '#') {
      token.kind = TokenKind::parameter;
      const std::size_t comment = line.find_first_of("(;", at);
      at = comment == std::string_view::npos || comment > newline ? newline : comment;
    } else if (c == '/') {
      token.kind = TokenKind::block_delete;
      ++at;
      if (at < newline && line[at] >= '0' && line[at] <= '9') ++at;
    } else {
      ++at;
      while (at < newline && !is_letter(line[at]) && !is_blank(line[at]) && line[at] != '(' && line[at] != ';') ++at;
    }
    token.end = static_cast<std::uint32_t>(at);
    tokens_.push_back(token);
  }
  return tokens_;
}

}  // namespace trunnion
