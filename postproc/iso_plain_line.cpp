#include "postproc/iso_scanner.h"

namespace trunnion {
namespace {

constexpr std::int64_t kFarthest_whole = static_cast<std::int64_t>(kFarthest);

}  // namespace

/// The words of a line that has nothing but plain numbers behind N, G0, G1, the axes and F, as nearly every one: what
/// tokens and collect() make of it, without the way over them. False, and nothing taken, for any other line.
bool IsoScanner::take_plain(std::string_view line, IsoWords& words) {
  const char* const first = line.data();
  const char* const end = first + line.size() - (line.ends_with("\n\r\r") ? 3 : line.ends_with("\n") ? 1 : 0);
  MotionBlock& block = move_.block;
  const auto give_up = [&] {
    const std::uint32_t line_begin = block.begin, line_end = block.end;
    move_.clear();
    block.begin = line_begin;
    block.end = line_end;
    words = {};
    words.begin = begin_;
    return false;
  };
  const auto offset = [&](const char* place) { return begin_ + static_cast<std::uint32_t>(place - first); };
  bool anything = false;
  for (const char* at = first;;) {
    const char* const before = at;
    while (at != end && (*at == ' ' || *at == '\t' || *at == '\r')) ++at;
    if (at == end) break;
    if (*at == ';' && rules_.syntax.semicolon_ends_block && at + 1 == end) break;
    const char* const text = at;
    const char letter = static_cast<char>(*at >= 'a' ? *at - ('a' - 'A') : *at);
    if (letter < 'A' || letter > 'Z') return give_up();
    ++at;
    while (at != end && (*at == ' ' || *at == '\t')) ++at;
    const char* const number = at;
    anything = true;
    const std::int8_t found = axis_by_letter_[static_cast<std::size_t>(letter - 'A')];
    WordPlace other;
    WordPlace& word = found >= 0 ? block.word[static_cast<std::size_t>(found)] : other;
    if (found >= 0 && holds(block.programmed, static_cast<std::size_t>(found))) return give_up();
    at = scan_plain_number(at, end, word.value, word.style);
    if (at == nullptr) return give_up();
    // What a number is followed by in the middle of a name or an expression.
    if (at != end && rules_.syntax.names && (*at == '_' || *at == ':' || *at == '=')) return give_up();
    word.text = offset(text);
    word.number = offset(number);
    word.number_end = word.end = offset(at);
    const Decimal value = word.value;
    if (found >= 0) {
      const std::int64_t size = value.mantissa < 0 ? -value.mantissa : value.mantissa;
      if (size > kFarthest_whole * power_of_ten(value.decimals) || (rules_.point_matters && !word.style.point))
        return give_up();
      block.programmed |= only(static_cast<std::size_t>(found));
      block.order[block.words++] = static_cast<std::uint8_t>(found);
      if (before != first) block.blank_before_words = text > before;
    } else if (letter == 'G') {
      const Code code = value.decimals == 0 && value.mantissa >= 0 && value.mantissa <= 1
                            ? code_of(static_cast<int>(10 * value.mantissa))
                            : Code::unknown;
      if ((code != Code::rapid && code != Code::line) || words.g_count == words.g.size()) return give_up();
      block.motion_word = {word.text, word.end};
      words.g[words.g_count++] = static_cast<int>(10 * value.mantissa);
    } else if (letter == 'F') {
      if (words.feed.end != 0 || value.mantissa < 0 || value.value() > kFastest) return give_up();
      words.feed = word;
    } else if (letter != 'N') {
      return give_up();
    }
  }
  anything_ |= anything;
  return true;
}

}  // namespace trunnion
