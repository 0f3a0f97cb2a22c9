#include "postproc/block.h"

#include <algorithm>
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

/// Behind the bracket that closes the one at `at`; texts in quotes may hold anything.
std::size_t closed(std::string_view line, std::size_t at, std::size_t end) {
  int depth = 0;
  for (bool quoted = false; at < end; ++at) {
    const char c = line[at];
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if (c == '(' || c == '[') ++depth;
    if ((c == ')' || c == ']') && --depth == 0) return at + 1;
  }
  return end;
}

std::size_t skip_blanks(std::string_view line, std::size_t at, std::size_t end) {
  while (at < end && (line[at] == ' ' || line[at] == '\t')) ++at;
  return at;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool in_name(char c) { return is_letter(c) || is_digit(c) || c == '_'; }

/// Behind operands and the operators between them.
std::size_t formula_end(std::string_view line, std::size_t at, std::size_t end) {
  for (bool operand = false; at < end;) {
    const std::size_t next = skip_blanks(line, at, end);
    if (next == end || line[next] == ';' || is_blank(line[next])) break;
    const char c = line[next];
    if (c == '(' || c == '[') {
      at = closed(line, next, end);
      operand = true;
    } else if (c == '"') {
      const std::size_t quote = line.find('"', next + 1);
      at = quote == std::string_view::npos || quote >= end ? end : quote + 1;
      operand = true;
    } else if (in_name(c) || c == '.' || c == '$') {
      if (operand) break;
      for (at = next; at < end && (in_name(line[at]) || line[at] == '.' || line[at] == '$');) ++at;
      operand = true;
    } else {
      at = next + 1;
      operand = false;
    }
  }
  return at;
}

bool equals(std::string_view text, std::string_view upper_case) {
  return text.size() == upper_case.size() &&
         std::equal(text.begin(), text.end(), upper_case.begin(), [](char a, char b) { return upper(a) == b; });
}

Counting counting_of(std::string_view name) {
  if (equals(name, "AC")) return Counting::absolute;
  if (equals(name, "IC")) return Counting::incremental;
  if (equals(name, "DC")) return Counting::shortest;
  if (equals(name, "ACP") || equals(name, "ACN")) return Counting::one_way;
  return Counting::modal;
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

/// A letter and a number, or what stands in the number's place.
std::size_t IsoTokenizer::plain(std::string_view line, std::size_t at, std::size_t newline, Token& token) const {
  token.letter = upper(line[at]);
  const std::size_t number = skip_blanks(line, at + 1, newline);
  token.name_end = static_cast<std::uint32_t>(at + 1);
  if (const auto scanned = scan_number(line.substr(number, newline - number))) {
    token.kind = TokenKind::word;
    token.value = scanned->number;
    token.style = scanned->style;
    token.number = static_cast<std::uint32_t>(number);
    token.number_end = static_cast<std::uint32_t>(number + scanned->length);
    return token.number_end;
  }
  token.kind = TokenKind::expression;
  return expression_end(line, number, newline);
}

/// Behind the = at `at`: a number, AC(number) and the like, or a formula.
std::size_t IsoTokenizer::assigned(std::string_view line, std::size_t at, std::size_t newline, Token& token) const {
  std::size_t number = skip_blanks(line, at + 1, newline);
  std::size_t name = number;
  while (name < newline && is_letter(line[name])) ++name;
  const Counting counting = counting_of(line.substr(number, name - number));
  const std::size_t bracket = skip_blanks(line, name, newline);
  const bool wrapped = counting != Counting::modal && bracket < newline && line[bracket] == '(';
  if (wrapped) number = skip_blanks(line, bracket + 1, newline);
  const std::size_t whole = formula_end(line, at + 1, newline);
  token.kind = TokenKind::expression;
  const auto scanned = scan_number(line.substr(number, newline - number));
  if (!scanned) return whole;
  std::size_t end = number + scanned->length;
  if (wrapped) {
    end = skip_blanks(line, end, newline);
    if (end >= newline || line[end] != ')') return whole;
    ++end;
  }
  if (end != whole) return whole;
  token.kind = TokenKind::word;
  token.counting = wrapped ? counting : Counting::modal;
  token.value = scanned->number;
  token.style = scanned->style;
  token.number = static_cast<std::uint32_t>(number);
  token.number_end = static_cast<std::uint32_t>(number + scanned->length);
  return end;
}

/// Where words may have several letters.
std::size_t IsoTokenizer::named(std::string_view line, std::size_t at, std::size_t newline, Token& token) const {
  std::size_t letters = at;
  while (letters < newline && (is_letter(line[letters]) || line[letters] == '_')) ++letters;
  std::size_t name = letters;
  while (name < newline && in_name(line[name])) ++name;
  const std::size_t next = skip_blanks(line, name, newline);
  token.name_end = static_cast<std::uint32_t>(name);
  const bool single = letters == at + 1 && line[at] != '_';
  const auto is = [&](std::size_t place, char c) { return place < newline && line[place] == c; };
  if (is(next, '=') && !is(next + 1, '=')) {
    token.letter = single && name == at + 1 ? upper(line[at]) : '\0';
    return assigned(line, next, newline, token);
  }
  if (is(next, '[')) {
    const std::size_t index = skip_blanks(line, closed(line, next, newline), newline);
    if (is(index, '=')) {
      token.kind = TokenKind::parameter;
      return formula_end(line, index + 1, newline);
    }
  }
  // A number goes on where a name would not: X1.5, G1X2.
  if (single && name < newline && (line[name] == '.' || name == at + 1)) return plain(line, at, newline, token);
  std::size_t digits = letters;
  while (digits < name && is_digit(line[digits])) ++digits;
  if (single && digits > letters && (digits == name || is_letter(line[digits]))) return plain(line, at, newline, token);
  if (is(name, ':') && !is(name + 1, '=')) {
    token.kind = TokenKind::label;
    return name + 1;
  }
  token.kind = TokenKind::name;
  return is(next, '(') ? closed(line, next, newline) : name;
}

std::span<const Token> IsoTokenizer::operator()(std::string_view line) {
  tokens_.clear();
  const std::size_t newline = line.ends_with("\n\r\r") ? line.size() - 3
                              : line.ends_with("\n")   ? line.size() - 1
                                                       : line.size();
  std::size_t at = 0;
  while (at < line.size()) {
    Token& token = tokens_.emplace_back();
    token.begin = static_cast<std::uint32_t>(at);
    while (at < newline && is_blank(line[at])) ++at;
    token.text = static_cast<std::uint32_t>(at);
    if (at >= newline) {
      token.kind = TokenKind::line_end;
      at = line.size();
    } else if (const char c = line[at]; is_letter(c)) {
      at = syntax_.names ? named(line, at, newline, token) : plain(line, at, newline, token);
    } else if (c == '(' && syntax_.bracket_comments) {
      token.kind = TokenKind::comment;
      const std::size_t close = line.find(')', at);
      at = close == std::string_view::npos || close >= newline ? newline : close + 1;
      if (line[at - 1] != ')') token.kind = TokenKind::other;
    } else if (c == ';' && syntax_.semicolon_ends_block) {
      token.kind = TokenKind::line_end;
      ++at;
    } else if (c == ';') {
      token.kind = TokenKind::comment;
      at = newline;
    } else if (c == '%') {
      token.kind = TokenKind::percent;
      at = newline;
    } else if (c == '#' && !syntax_.names) {
      token.kind = TokenKind::parameter;
      const std::size_t comment = line.find_first_of("(;", at);
      at = comment == std::string_view::npos || comment > newline ? newline : comment;
    } else if ((c == '$' || c == '_') && syntax_.names) {
      token.kind = TokenKind::parameter;
      at = formula_end(line, at, newline);
    } else if (c == '/') {
      token.kind = TokenKind::block_delete;
      ++at;
      if (at < newline && line[at] >= '0' && line[at] <= '9') ++at;
    } else {
      ++at;
      while (at < newline && !is_letter(line[at]) && !is_blank(line[at]) && line[at] != '(' && line[at] != ';') ++at;
    }
    token.end = static_cast<std::uint32_t>(at);
  }
  return tokens_;
}

}  // namespace trunnion
