#include "postproc/dialects/klartext_line.h"

#include <algorithm>
#include <cctype>

namespace trunnion {
namespace {

bool is_letter(char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\0' || c == '\x7f'; }
bool is_sign(char c) { return c == '+' || c == '-'; }

}  // namespace

KlartextLine::KlartextLine(std::string_view line) : line_(line) {
  std::size_t end = line.size();
  while (end > 0 && (line[end - 1] == '\n' || is_blank(line[end - 1]))) --end;
  std::size_t at = 0;
  const auto skip = [&] {
    while (at < end && is_blank(line[at])) ++at;
  };
  const auto skip_slash = [&] {
    skip();
    if (at >= end || line[at] != '/') return;
    optional_ = true;
    ++at;
    skip();
  };
  skip_slash();
  while (at < end && is_digit(line[at])) ++at;
  skip_slash();
  text_ = at;
  while (at < end) {
    if (line[at] == ';' || (line[at] == '*' && at == text_)) {
      comment_ = line.substr(at, end - at);
      break;
    }
    if (line[at] == '~') {
      ++at;
    } else if (line[at] == '"') {
      strange_ = true;
      at = std::min(line.find('"', at + 1), end - 1) + 1;
    } else if (!is_letter(line[at])) {
      strange_ = true;
      ++at;
    } else {
      at = take(at, end);
    }
    skip();
  }
}

std::string KlartextLine::text() const {
  std::string upper(line_.substr(std::min(text_, line_.size())));
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return upper;
}

std::size_t KlartextLine::take(std::size_t at, std::size_t end) {
  Piece piece;
  piece.place.text = static_cast<std::uint32_t>(at);
  while (at < end && is_letter(line_[at]))
    piece.name += static_cast<char>(std::toupper(static_cast<unsigned char>(line_[at++])));
  std::size_t number = at;
  while (number < end && line_[number] == ' ') ++number;
  if (number < end && (is_digit(line_[number]) || (number == at && line_[number] == '.') || is_sign(line_[number])))
    at = value(number, end, piece);
  piece.place.end = static_cast<std::uint32_t>(at);
  pieces_.push_back(std::move(piece));
  return at;
}

std::size_t KlartextLine::value(std::size_t at, std::size_t end, Piece& piece) {
  std::size_t digits = at + (is_sign(line_[at]) ? 1 : 0);
  if (digits < end && (line_[digits] == 'Q' || line_[digits] == 'q')) {
    const std::size_t name = digits;
    while (digits < end && (is_letter(line_[digits]) || is_digit(line_[digits]))) ++digits;
    piece.variable = true;
    piece.variable_name = line_.substr(name, digits - name);
    return digits;
  }
  std::string text(line_.substr(at, end - at));
  const std::size_t length = text.find_first_not_of("+-0123456789.,");
  if (length != std::string::npos) text.resize(length);
  const std::size_t comma = text.find(',');
  if (comma != std::string::npos) text[comma] = '.';
  const auto scanned = scan_number(text);
  if (!scanned || scanned->length == 0) {
    if (is_sign(line_[at]) && text.size() == 1) {
      piece.sign = line_[at];
      return at + 1;
    }
    strange_ = true;
    return at + std::max<std::size_t>(text.size(), 1);
  }
  piece.number = true;
  piece.place.value = scanned->number;
  piece.place.style = scanned->style;
  piece.place.style.comma = comma != std::string::npos && comma < scanned->length;
  piece.place.number = static_cast<std::uint32_t>(at);
  piece.place.number_end = static_cast<std::uint32_t>(at + scanned->length);
  piece.sign = line_[at];
  return piece.place.number_end;
}

}  // namespace trunnion
