#include "postproc/iso_scanner.h"

#include <algorithm>
#include <cmath>

namespace trunnion {
namespace {

std::optional<int> code_tenths(Decimal n) {
  if (n.decimals == 0 && n.mantissa >= 0 && n.mantissa <= 999) return static_cast<int>(10 * n.mantissa);
  const std::int64_t scale = power_of_ten(n.decimals);
  if (n.mantissa < 0 || n.mantissa / scale > 999 || (n.mantissa % scale) * 10 % scale != 0) return std::nullopt;
  return static_cast<int>(n.mantissa / scale * 10 + (n.mantissa % scale) * 10 / scale);
}

int tenths(const Token& token) {
  const std::optional<int> code = code_tenths(token.value);
  if (!code) bad(std::string(1, token.letter) + " code that does not exist");
  return *code;
}

constexpr std::string_view kArcLetters = "IJKRP";

}  // namespace

std::string code_name(char letter, int tenths) {
  std::string name = letter + std::to_string(tenths / 10);
  if (tenths % 10 != 0) name += "." + std::to_string(tenths % 10);
  return name;
}

IsoScanner::IsoScanner(const ScanSettings& settings, const IsoRules& rules, std::span<const CodeEntry> codes)
    : state_(settings),
      settings_(settings),
      rules_(rules),
      codes_(codes),
      tokenize_(rules.syntax),
      motion_(rules.first_motion) {
  for (std::size_t i = 0; i < codes.size(); ++i)
    index_[static_cast<std::size_t>(codes[i].tenths)] = static_cast<std::uint8_t>(i + 1);
  axis_by_letter_.fill(-1);
  for (std::size_t i = 0; i < kAxes; ++i)
    axis_by_letter_[static_cast<std::size_t>(settings.letters[i] - 'A')] = static_cast<std::int8_t>(i);
}

std::optional<std::size_t> IsoScanner::axis_of(char letter) const {
  if (letter < 'A' || letter > 'Z') return std::nullopt;
  const std::int8_t axis = axis_by_letter_[static_cast<std::size_t>(letter - 'A')];
  if (axis < 0) return std::nullopt;
  return static_cast<std::size_t>(axis);
}

const CodeEntry* IsoScanner::entry(int tenths) const {
  const std::uint8_t i = index_[static_cast<std::size_t>(tenths)];
  return i == 0 ? nullptr : &codes_[i - 1u];
}

Code IsoScanner::code_of(int tenths) const {
  const CodeEntry* found = entry(tenths);
  return found == nullptr ? Code::unknown : found->code;
}

bool IsoScanner::arc_mode() const {
  const Code code = code_of(motion_);
  return code == Code::clockwise || code == Code::counter_clockwise;
}

WordPlace IsoScanner::place(const Token& token) const {
  return {begin_ + token.text, begin_ + token.number, begin_ + token.number_end,
          begin_ + token.end,  token.value,           token.style};
}

bool IsoScanner::scan(std::string_view line, std::uint32_t begin, ScannedChunk& chunk) {
  ++line_;
  ++chunk.lines;
  if (ended_ || lost_) return true;
  begin_ = begin;
  codes_followed_ = false;
  try {
    current_ = line;
    begin_block();
    move_.clear();
    move_.block.begin = begin;
    move_.block.end = begin + static_cast<std::uint32_t>(line.size());
    IsoWords words;
    words.begin = begin;
    if (take_plain(line, words)) {
      execute(words, chunk);
      return true;
    }
    const std::span<const Token> tokens = tokenize_(line);
    if (tokens.front().kind == TokenKind::percent && !rules_.syntax.names) {
      if (anything_ && !percent_) bad("% in a program that does not begin with one");
      ended_ = percent_;
      percent_ = anything_ = true;
      return true;
    }
    collect(tokens, line, words);
    execute(words, chunk);
  } catch (const LineRefused& refused) {
    lost_ = refused.lasting || !follow_codes(line);
    Refusal::Kind kind = refused.kind;
    // Lines may stand for the arcs before it, and then it is no longer what it was.
    if (kind == Refusal::Kind::refused && arc_mode() && !move_.block.motion_word.stands())
      kind = Refusal::Kind::for_good;
    chunk.refusals.push_back({line_, refused.reason + (settings_.keep_going && lost_ ? kCopiedToEnd : ""), kind,
                              lost_ ? Refusal::Behind::copied : Refusal::Behind::axes_unknown});
    state_.forget(kAllAxes);  // where the machine goes from here is not known
    return settings_.keep_going && kind == Refusal::Kind::refused;
  }
  return true;
}

/// What a block that was refused says beside its move: false where modes or zeros are no longer known.
bool IsoScanner::follow_codes(std::string_view line) {
  if (codes_followed_) return true;
  state_.feed = 0;
  for (const Token& token : tokenize_(line)) {
    if (token.kind == TokenKind::name || token.kind == TokenKind::parameter ||
        (token.kind == TokenKind::word && token.letter == 0))
      return false;
    if (token.kind != TokenKind::word || token.letter != 'G') continue;
    const auto known = code_tenths(token.value);
    const Code code = known ? code_of(*known) : Code::unknown;
    if (code == Code::rapid || code == Code::line || code == Code::clockwise || code == Code::counter_clockwise ||
        code == Code::other_motion)
      motion_ = *known;
    else if (code == Code::cycle)
      cycle_ = *known;
    else if (code != Code::harmless && code != Code::taken_for_harmless && code != Code::machine_coordinates &&
             code != Code::home)
      return false;
  }
  return true;
}

// --- reading a block
// --------------------------------------------------------------------------------------------------

void IsoScanner::collect(std::span<const Token> tokens, std::string_view line, IsoWords& words) {
  bool ended = false;
  for (const Token& token : tokens) {
    if (token.kind == TokenKind::line_end) {
      ended = true;
      continue;
    }
    anything_ = true;
    if (words.rest_ignored && token.kind != TokenKind::comment) continue;
    if (ended && token.kind != TokenKind::comment) bad("a second block behind ; on one line");
    switch (token.kind) {
      case TokenKind::word:
        take_word(token, line, words);
        break;
      case TokenKind::expression:
        take_expression(token, words);
        break;
      case TokenKind::parameter:
        take_parameter(line.substr(token.text, token.end - token.text));
        break;
      case TokenKind::comment:
        if (contains_mark(line.substr(token.text, token.end - token.text))) refuse_corrected();
        break;
      case TokenKind::block_delete:
        words.optional = true;
        break;
      case TokenKind::name:
        take_name(line, token, words);
        break;
      case TokenKind::label:
        break;
      case TokenKind::percent:
        if (rules_.syntax.names) break;
        bad("% in a block; it stands on a line of its own");
        break;
      default: {
        if (take_other(line.substr(token.text, token.end - token.text))) break;
        std::string found(line.substr(token.text, std::min<std::size_t>(token.end - token.text, 16)));
        for (char& c : found)
          if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e) c = '?';
        if (found[0] == '(') bad("a comment that is not closed: " + found);
        bad("'" + found + "' is no word of a block");
      }
    }
  }
}

Decimal IsoScanner::value_of(const Token& token, std::size_t) const { return token.value; }

void IsoScanner::take_axis(std::size_t axis, const Token& token) {
  WordPlace word = place(token);
  word.value = value_of(token, axis);
  word.style.point |= word.value.decimals != token.value.decimals;
  move_.add(axis, word, token.letter);
  if (token.begin != 0) move_.block.blank_before_words = token.text > token.begin;
}

void IsoScanner::take_word(const Token& token, std::string_view line, IsoWords& words) {
  if (token.letter == 0) return take_name(line, token, words);
  if (token.value.decimals == 0 ? token.value.mantissa > 1000000 || token.value.mantissa < -1000000
                                : std::abs(token.value.value()) > kFarthest)
    if (rules_.letters_of_moves.find(token.letter) != std::string_view::npos)
      bad(std::string(1, token.letter) + " is beyond 1000000");
  if (const auto axis = axis_of(token.letter)) {
    if (token.counting != Counting::modal) take_letter(token, words);
    return take_axis(*axis, token);
  }
  switch (token.letter) {
    case 'N':
      break;
    case 'G': {
      if (words.g_count == words.g.size()) bad("more than 16 G codes in one block");
      const int code = tenths(token);
      const Code kind = code_of(code);
      const TextPlace here{begin_ + token.text, begin_ + token.end};
      if (kind == Code::rapid || kind == Code::line || kind == Code::clockwise || kind == Code::counter_clockwise)
        move_.block.motion_word = here;
      if (kind == Code::inverse_time || kind == Code::per_minute || kind == Code::per_revolution) {
        move_.has_extras = true;
        move_.extras.feed_mode_word = here;
      }
      words.g[words.g_count++] = code;
      break;
    }
    case 'M': {
      if (words.m_count == words.m.size()) bad("more than 8 M codes in one block");
      const int code = tenths(token);
      if (code % 10 != 0) bad(code_name('M', code) + ": an M code is a whole number");
      words.m[words.m_count++] = code / 10;
      break;
    }
    case 'F':
      if (words.feed.end != 0) bad("F stands twice in one block");
      if (token.value.mantissa < 0) bad("F is negative");
      if (token.value.value() > kFastest) bad("F is beyond 1000000000");
      words.feed = place(token);
      break;
    case 'I':
    case 'J':
    case 'K':
    case 'R':
    case 'P': {
      const Token*& found = words.arc[kArcLetters.find(token.letter)];
      if (found != nullptr) bad(std::string(1, token.letter) + " stands twice in one block");
      found = &token;
      if (token.counting != Counting::modal) take_letter(token, words);
      break;
    }
    case 'L':
      words.offset_letter = true;
      take_letter(token, words);
      break;
    case 'A':
    case 'B':
    case 'C':
    case 'U':
    case 'V':
    case 'W':
      refuse_move(std::string(1, token.letter) + ": this machine has no such axis");
      break;
    default:
      if (rules_.harmless_letters.find(token.letter) == std::string_view::npos) take_letter(token, words);
  }
}

void IsoScanner::take_letter(const Token& token, IsoWords&) {
  if (rules_.harmless_letters.find(token.letter) == std::string_view::npos)
    bad(std::string(1, token.letter) + " is no word of this dialect");
}

void IsoScanner::take_expression(const Token& token, IsoWords& words) {
  const std::string letter(1, token.letter);
  if (token.letter == 'F') {
    words.feed_expression = true;
  } else if (token.letter == 'P' && rules_.turns_letter == 'P') {
    words.turns_expression = true;
  } else if (rules_.harmless_expressions.find(token.letter) == std::string_view::npos) {
    const std::string computed =
        letter + " is not followed by a plain number; variables and expressions in motion words are not computed";
    if (axis_of(token.letter) || std::string_view("IJKRUVWABC").find(token.letter) != std::string_view::npos)
      refuse_move(computed);
    if (std::string_view("GML").find(token.letter) != std::string_view::npos) refuse(computed);
    bad(letter + " is no word of this dialect, or its number is missing or has more than 18 digits");
  }
}

void IsoScanner::take_parameter(std::string_view) {}
void IsoScanner::take_name(std::string_view, const Token&, IsoWords&) { bad("a name is no word of this dialect"); }
void IsoScanner::begin_block() {}
bool IsoScanner::take_other(std::string_view) { return false; }
void IsoScanner::take_code(int, IsoWords&) {}
bool IsoScanner::take_block(IsoWords&, ScannedChunk&) { return false; }

// --- executing it, in the control's order
// -----------------------------------------------------------------------------

void IsoScanner::apply(int g, IsoWords& words) {
  const CodeEntry* found = entry(g);
  const Code code = found == nullptr ? Code::unknown : found->code;
  words.changes_state |=
      code != Code::harmless && code != Code::taken_for_harmless && code != Code::dwell && code != Code::home;
  switch (code) {
    case Code::unknown:
      refuse(code_name('G', g) + " is not known to dialect " + std::string(rules_.dialect));
      break;
    case Code::harmless:
      break;
    case Code::taken_for_harmless:
      assumptions_ |= only(Assumption::high_speed_by_number);
      break;
    case Code::rapid:
    case Code::line:
    case Code::clockwise:
    case Code::counter_clockwise:
    case Code::no_motion:
    case Code::other_motion:
      if (words.motion >= 0) bad(code_name('G', words.motion) + " and " + code_name('G', g) + " in one block");
      words.motion = g;
      break;
    case Code::plane_xy:
      state_.plane = {0, 1, 2};
      break;
    case Code::plane_zx:
      state_.plane = {2, 0, 1};
      break;
    case Code::plane_yz:
      state_.plane = {1, 2, 0};
      break;
    case Code::inch:
    case Code::metric: {
      const double unit = code == Code::inch ? kInch_mm : 1;
      words.changes_modes |= unit != state_.unit_mm;
      state_.unit_mm = unit;
      feed_unit_told_ = !(rules_.machine_feed_below_tenths > g && code == Code::inch);
      break;
    }
    case Code::cutter_on:
      state_.cutter = "G41 or G42";
      break;
    case Code::cutter_off:
      state_.cutter = {};
      break;
    case Code::tool_length:
      tool_length_changed_ = words.changes_modes = true;
      break;
    case Code::work_offset:
      state_.select_offset(code_name('G', g));
      words.changes_modes = true;
      break;
    case Code::absolute:
    case Code::incremental:
      words.changes_modes |= state_.incremental != (code == Code::incremental);
      state_.incremental = code == Code::incremental;
      break;
    case Code::inverse_time:
      state_.feed_mode = FeedMode::inverse_time;
      words.changes_modes = true;
      break;
    case Code::per_minute:
      state_.feed_mode = FeedMode::per_minute;
      words.changes_modes = true;
      break;
    case Code::per_revolution:
      state_.feed_mode = FeedMode::per_revolution;
      words.changes_modes = true;
      break;
    case Code::machine_coordinates:
      words.machine_coordinates = true;
      break;
    case Code::dwell:
      words.dwell = true;
      break;
    case Code::absolute_centre:
      absolute_centre_ = true;
      break;
    case Code::relative_centre:
      absolute_centre_ = false;
      break;
    case Code::refused:
      refuse(code_name('G', g) + ": " + found->reason);
      break;
    case Code::cycle:
      cycle_ = g;
      refuse_move(code_name('G', g) + ": " + found->reason);
      break;
    case Code::cycle_end:
      cycle_ = -1;
      break;
    case Code::special:
      take_code(g, words);
      break;
    case Code::home:
    case Code::alone:
      if (words.alone >= 0) bad(code_name('G', words.alone) + " and " + code_name('G', g) + " in one block");
      words.alone = g;
      words.home = code == Code::home;
      break;
  }
}

void IsoScanner::execute(IsoWords& words, ScannedChunk& chunk) {
  const double feed_unit_before = state_.unit_mm;
  for (std::size_t i = 0; i < words.g_count; ++i) apply(words.g[i], words);
  for (std::size_t i = 0; i < words.m_count; ++i) take_m(words.m[i], words);
  codes_followed_ = true;
  chunk.assumptions |= assumptions_;
  if (!(words.dwell && rules_.dwell_takes_feed) && (words.feed.end != 0 || words.feed_expression)) {
    state_.feed = feed_unit_told_ && !words.optional ? words.feed.value.value() : 0;
    state_.feed_unit_mm = feed_unit_before;
    if (words.feed.end != 0) move_.block.feed_word = words.feed;
  }
  if (words.tool_change) state_.forget(kAllAxes);
  if (tool_length_changed_) {
    state_.forget(only(2));
    tool_length_changed_ = false;
  }
  if (words.motion >= 0) {
    motion_ = words.motion;
    cycle_ = -1;
  }
  if ((words.alone >= 0 || words.home) && words.optional && move_.block.words > 0)
    refuse_move("/ before " + code_name('G', words.alone) + ": whether it runs is not known");
  if (words.home) {
    forget_words();
    ++chunk.copied_moves;
  } else if (words.alone >= 0) {
    if (!take_block(words, chunk) && move_.block.words > 0)
      refuse(code_name('G', words.alone) + " with axis words is not followed");
  } else if (!take_block(words, chunk)) {
    run_move(words, chunk);
  }
  if (words.optional && (words.changes_state || words.tool_change || words.ends))
    refuse("/ before a block that changes modes, zeros or tools, or ends the program: whether it runs is not known");
  if (words.ends) ended_ = true;
}

}  // namespace trunnion
