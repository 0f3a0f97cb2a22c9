#include "postproc/dialects/linuxcnc.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <span>

namespace trunnion {
namespace {

constexpr double kInch_mm = 25.4;
constexpr double kFarthest = 1e6;  // mm, inch or degrees: beyond any machine, within exact arithmetic of its digits
constexpr double kFastest = 1e9;
constexpr int kFinestDecimals = 6;  // of a corrected word, however many the program shows
constexpr int kNoMotion = 800;      // G80

/// Thrown inside one line, told with its number by scan().
struct LineRefused {
  std::string reason;
  Refusal::Kind kind = Refusal::Kind::refused;
};

/// "G43.1" of 431.
std::string code_name(char letter, int tenths) {
  std::string name = letter + std::to_string(tenths / 10);
  if (tenths % 10 != 0) name += "." + std::to_string(tenths % 10);
  return name;
}

[[noreturn]] void refuse(const std::string& what) { throw LineRefused{what}; }
[[noreturn]] void bad(const std::string& what) { throw LineRefused{what, Refusal::Kind::bad_input}; }

bool contains_mark(std::string_view comment) {
  const auto same = [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; };
  return std::search(comment.begin(), comment.end(), kCorrectedMark.begin(), kCorrectedMark.end(), same) !=
         comment.end();
}

/// The words of one block, sorted by what they are.
struct Words {
  std::array<int, 16> g{};  ///< G codes in tenths
  std::size_t g_count = 0;
  std::array<int, 8> m{};
  std::size_t m_count = 0;
  std::array<const Token*, kAxes> axis{};
  std::array<std::uint8_t, kAxes> order{};
  std::uint8_t axes = 0;
  const Token* feed = nullptr;
  const Token* feed_mode = nullptr;
  bool feed_expression = false;
  const Token* motion = nullptr;      ///< the G code that moves
  std::array<const Token*, 5> arc{};  ///< I J K R P
  bool offset_letter = false;         ///< L
  bool optional = false;              ///< block delete
  bool tool_word = false;
  bool blank_before_words = true;

  bool has_centre() const { return arc[0] != nullptr || arc[1] != nullptr || arc[2] != nullptr; }
};

class LinuxcncScanner : public ProgramScanner {
 public:
  explicit LinuxcncScanner(const ScanSettings& settings) : settings_(settings) {}

  bool scan(std::string_view line, std::uint32_t begin, ScannedChunk& chunk) override {
    ++line_;
    ++chunk.lines;
    if (ended_) return true;
    try {
      const std::span<const Token> tokens = tokenize_(line);
      if (tokens.front().kind == TokenKind::percent) {
        if (anything_ && !percent_) bad("% in a program that does not begin with one");
        ended_ = percent_;
        percent_ = anything_ = true;
        return true;
      }
      execute(collect(tokens, line), begin, begin + static_cast<std::uint32_t>(line.size()), chunk);
    } catch (const LineRefused& refused) {
      chunk.refusals.push_back({line_, refused.reason, refused.kind});
      known_ = 0;  // where the machine goes from here is not known
      return settings_.keep_going && refused.kind == Refusal::Kind::refused;
    }
    return true;
  }

 private:
  // --- reading a block
  // ------------------------------------------------------------------------------------------------

  std::optional<std::size_t> axis_of(char letter) const {
    for (std::size_t i = 0; i < kAxes; ++i)
      if (settings_.letters[i] == letter) return i;
    return std::nullopt;
  }

  Words collect(std::span<const Token> tokens, std::string_view line) {
    Words words;
    for (const Token& token : tokens) {
      if (token.kind == TokenKind::line_end) continue;
      anything_ = true;
      switch (token.kind) {
        case TokenKind::word:
          take_word(token, words);
          break;
        case TokenKind::expression:
          take_expression(token, words);
          break;
        case TokenKind::parameter:
          take_parameter(line.substr(token.text, token.end - token.text));
          break;
        case TokenKind::comment:
          if (contains_mark(line.substr(token.text, token.end - token.text)))
            refuse("this program has been corrected already; correct the original");
          break;
        case TokenKind::block_delete:
          words.optional = true;
          break;
        case TokenKind::percent:
          bad("% in a block; it stands on a line of its own");
          break;
        default: {
          std::string found(line.substr(token.text, std::min<std::size_t>(token.end - token.text, 16)));
          for (char& c : found)
            if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e) c = '?';
          if (found[0] == '(') bad("a comment that is not closed: " + found);
          bad("'" + found + "' is no word of a block");
        }
      }
    }
    return words;
  }

  void take_word(const Token& token, Words& words) {
    if (std::string_view("XYZABCUVWIJKR").find(token.letter) != std::string_view::npos &&
        std::abs(token.number.value()) > kFarthest)
      bad(std::string(1, token.letter) + " is beyond 1000000");
    if (const auto axis = axis_of(token.letter)) {
      if (words.axis[*axis] != nullptr) bad(std::string(1, token.letter) + " stands twice in one block");
      words.axis[*axis] = &token;
      words.order[words.axes++] = static_cast<std::uint8_t>(*axis);
      if (token.begin != 0) words.blank_before_words = token.text > token.begin;
      return;
    }
    switch (token.letter) {
      case 'G': {
        if (words.g_count == words.g.size()) bad("more than 16 G codes in one block");
        const int code = tenths(token);
        if (code == 0 || code == 10 || code == 20 || code == 30) words.motion = &token;
        if (code == 930 || code == 940 || code == 950) words.feed_mode = &token;
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
        if (words.feed != nullptr) bad("F stands twice in one block");
        if (token.number.mantissa < 0) bad("F is negative");
        if (token.number.value() > kFastest) bad("F is beyond 1000000000");
        words.feed = &token;
        break;
      case 'I':
      case 'J':
      case 'K':
      case 'R':
      case 'P': {
        const Token*& place = words.arc[std::string_view("IJKRP").find(token.letter)];
        if (place != nullptr) bad(std::string(1, token.letter) + " stands twice in one block");
        place = &token;
        break;
      }
      case 'L':
        words.offset_letter = true;
        break;
      case 'T':
        words.tool_word = true;
        break;
      case 'D':
      case 'E':
      case 'H':
      case 'N':
      case 'Q':
      case 'S':
        break;
      case 'O':
        refuse("O word: subprograms and loops; post the program without them");
        break;
      case 'A':
      case 'B':
      case 'C':
      case 'U':
      case 'V':
      case 'W':
        refuse(std::string(1, token.letter) + ": this machine has no such axis");
        break;
      default:
        bad(std::string(1, token.letter) + " is no word of this dialect");
    }
  }

  bool arc_mode() const { return motion_ == 20 || motion_ == 30; }

  static int tenths(const Token& token) {
    const Decimal n = token.number;
    const std::int64_t scale = power_of_ten(n.decimals);
    if (n.mantissa < 0 || n.mantissa / scale > 999 || (n.mantissa % scale) * 10 % scale != 0)
      bad(std::string(1, token.letter) + " code that does not exist");
    return static_cast<int>(n.mantissa / scale * 10 + (n.mantissa % scale) * 10 / scale);
  }

  void take_expression(const Token& token, Words& words) {
    const std::string letter(1, token.letter);
    switch (token.letter) {
      case 'F':
        words.feed_expression = true;
        break;
      case 'S':
      case 'D':
      case 'P':
      case 'H':
      case 'Q':
        break;
      case 'T':
        words.tool_word = true;
        break;
      case 'O':
        refuse("O word: subprograms and loops; post the program without them");
        break;
      default:
        if (axis_of(token.letter) || std::string_view("IJKRGMLUVWABC").find(token.letter) != std::string_view::npos)
          refuse(letter +
                 " is not followed by a plain number; variables and expressions in motion words are not computed");
        bad(letter + " is no word of this dialect, or its number is missing or has more than 18 digits");
    }
  }

  /// Assignments are harmless as long as no word that moves uses them, but numbers from 5000 on are the control's own.
  static void take_parameter(std::string_view text) {
    const std::size_t digit = text.find_first_not_of(" \t", 1);
    if (digit != std::string_view::npos && text[digit] == '<') return;
    const auto number = scan_number(text.substr(std::min(digit, text.size())));
    if (!number || number->number.decimals != 0) refuse("# parameter by a computed number");
    if (number->number.mantissa > 5000 || number->number.mantissa < 1)
      refuse("#" + std::to_string(number->number.mantissa) +
             ": a parameter of the control itself, it may move its zero");
  }

  // --- executing it, in the control's order
  // -----------------------------------------------------------------------------

  void execute(const Words& words, std::uint32_t begin, std::uint32_t end, ScannedChunk& chunk) {
    const double feed_unit_before = unit_mm_;
    bool machine_coordinates = false, changes_modes = false, stops = false, reached_end = false, pauses = false;
    int nonmodal = -1, motion = -1;
    for (std::size_t i = 0; i < words.g_count; ++i) {
      const int g = words.g[i];
      switch (g) {
        case 0:
        case 10:
        case 20:
        case 30:
        case 330:
        case 331:
        case 382:
        case 383:
        case 384:
        case 385:
        case 50:
        case 51:
        case 52:
        case 53:
        case 730:
        case 740:
        case 760:
        case 800:
        case 810:
        case 820:
        case 830:
        case 840:
        case 850:
        case 860:
        case 870:
        case 880:
        case 890:
          if (motion >= 0) bad(code_name('G', motion) + " and " + code_name('G', g) + " in one block");
          motion = g;
          break;
        case 40:
          pauses = true;
          break;
        case 640:
          pauses = true;
          break;
        case 80:
        case 610:
        case 611:
        case 960:
        case 970:
        case 980:
        case 990:
          break;
        case 901:
          absolute_centre_ = true;
          break;
        case 911:
          absolute_centre_ = false;
          break;
        case 170:
          plane_ = {0, 1, 2};
          break;
        case 180:
          plane_ = {2, 0, 1};
          break;
        case 190:
          plane_ = {1, 2, 0};
          break;
        case 200:
          set_unit(kInch_mm, changes_modes);
          break;
        case 210:
          set_unit(1, changes_modes);
          break;
        case 400:
          cutter_ = false;
          break;
        case 410:
        case 411:
        case 420:
        case 421:
          cutter_ = true;
          break;
        case 430:
        case 431:
        case 432:
        case 490:
          tool_length_changed_ = true;
          changes_modes = true;
          if (g == 431) nonmodal = g;
          break;
        case 540:
        case 550:
        case 560:
        case 570:
        case 580:
        case 590:
        case 591:
        case 592:
        case 593:
          system_ = code_name('G', g);
          offset_known_ = false;
          changes_modes = true;
          break;
        case 900:
          changes_modes |= incremental_;
          incremental_ = false;
          break;
        case 910:
          changes_modes |= !incremental_;
          incremental_ = true;
          break;
        case 930:
          feed_mode_ = FeedMode::inverse_time;
          changes_modes = true;
          break;
        case 940:
          feed_mode_ = FeedMode::per_minute;
          changes_modes = true;
          break;
        case 950:
          feed_mode_ = FeedMode::per_revolution;
          changes_modes = true;
          break;
        case 530:
          machine_coordinates = true;
          break;
        case 100:
        case 280:
        case 281:
        case 300:
        case 301:
        case 520:
        case 920:
        case 921:
        case 922:
        case 923:
          if (nonmodal >= 0) bad(code_name('G', nonmodal) + " and " + code_name('G', g) + " in one block");
          nonmodal = g;
          break;
        case 70:
          refuse("G7: diameter programming belongs to a lathe");
          break;
        case 171:
        case 181:
        case 191:
          refuse(code_name('G', g) + ": planes of U V W");
          break;
        default:
          refuse(code_name('G', g) + " is not known to dialect linuxcnc");
          break;
      }
    }
    bool tool_change = false;
    for (std::size_t i = 0; i < words.m_count; ++i) {
      const int m = words.m[i];
      if (m == 6 || m == 61)
        tool_change = true;
      else if (m == 2 || m == 30)
        reached_end = stops = true;
      else if (m == 0 || m == 1 || m == 60)
        stops = true;
      else if (m == 98 || m == 99)
        refuse("M" + std::to_string(m) + ": subprogram call; post the program without it");
      else if (m >= 70 && m <= 73)
        refuse("M" + std::to_string(m) + ": saved and restored modes are not followed");
      else if (!((m >= 3 && m <= 9) || m == 19 || (m >= 48 && m <= 53) || (m >= 62 && m <= 68) ||
                 (m >= 100 && m <= 199)))
        refuse("M" + std::to_string(m) + " is not known to dialect linuxcnc");
    }
    if (words.feed != nullptr || words.feed_expression) {
      feed_ = words.feed != nullptr ? words.feed->number.value() : 0;
      feed_unit_mm_ = feed_unit_before;
    }
    if (tool_change) known_ = 0;
    if (tool_length_changed_) {
      known_ &= static_cast<AxisSet>(~only(2));
      tool_length_changed_ = false;
    }
    if (motion >= 0) motion_ = motion;

    if (nonmodal >= 0) {
      if (words.optional && words.axes > 0)
        refuse("/ before " + code_name('G', nonmodal) + ": whether it runs is not known");
      execute_nonmodal(nonmodal, words, begin, end, chunk);
    } else if (words.axes > 0 || (arc_mode() && words.has_centre())) {
      if (words.optional) refuse("/ before a block that moves: whether it runs is not known");
      if (machine_coordinates) {
        if (motion_ != 0 && motion_ != 10) refuse("G53 without G0 or G1");
        forget(words);
        ++chunk.copied_moves;
      } else {
        if (arc_mode() && pauses && words.arc[4] != nullptr)
          bad("P in a block with an arc and G4 or G64 has two meanings");
        move(words, begin, end, {changes_modes, stops, tool_change}, chunk);
      }
    } else if (motion == 20 || motion == 30) {
      bad(code_name('G', motion) + " without axis words");
    } else if (motion >= 0 && motion != 0 && motion != 10 && motion != kNoMotion) {
      refuse_motion(motion);
    }
    if (reached_end) ended_ = true;
  }

  void set_unit(double unit_mm, bool& changes_modes) {
    changes_modes |= unit_mm != unit_mm_;
    unit_mm_ = unit_mm;
  }

  /// Axes that go where the program does not say; without words, all of them.
  void forget(const Words& words) {
    AxisSet gone = 0;
    for (std::size_t i = 0; i < words.axes; ++i) gone |= only(words.order[i]);
    known_ &= static_cast<AxisSet>(~(gone != 0 ? gone : kAllAxes));
  }

  void execute_nonmodal(int code, const Words& words, std::uint32_t begin, std::uint32_t end, ScannedChunk& chunk) {
    switch (code) {
      case 280:
      case 300:
        forget(words);
        ++chunk.copied_moves;
        break;
      case 281:
      case 301:
      case 431:
        break;
      case 100:
        if (words.axes > 0 || !words.offset_letter)
          refuse("G10: sets offsets or tools while the program runs; give them in the job");
        break;
      case 520:
        for (std::size_t i = 0; i < words.axes; ++i) {
          const std::size_t axis = words.order[i];
          shift_[axis] = scale(axis) * words.axis[axis]->number.value();
        }
        break;
      case 920:
        set_position(words, begin, end, chunk);
        break;
      case 921:
        shift_ = stored_shift_ = {};
        break;
      case 922:
        stored_shift_ = shift_;
        shift_ = {};
        break;
      case 923:
        shift_ = stored_shift_;
        break;
      default:
        break;
    }
  }

  double scale(std::size_t axis) const { return axis < 3 ? unit_mm_ : 1; }

  void set_position(const Words& words, std::uint32_t begin, std::uint32_t end, ScannedChunk& chunk) {
    if (words.axes == 0) bad("G92 without axis words");
    MotionBlock block = describe(words, begin, end);
    for (std::size_t i = 0; i < words.axes; ++i) {
      const std::size_t axis = words.order[i];
      if (!holds(known_, axis))
        refuse(std::string("G92 ") + settings_.letters[axis] + ": where the axis stands is not known here");
      shift_[axis] = at_[axis] - work_zero(axis) - scale(axis) * words.axis[axis]->number.value();
    }
    block.kind = BlockKind::set_position;
    block.from = block.target = at_;
    block.raw_since = raw_since_;
    chunk.blocks.push_back(block);
  }

  double work_zero(std::size_t axis) {
    if (axis >= 3) return 0;
    if (!offset_known_) {
      offset_ = {};
      if (!settings_.work_offsets_mm.empty()) {
        const auto found = settings_.work_offsets_mm.find(system_);
        if (found == settings_.work_offsets_mm.end()) refuse(system_ + ": the job gives no work offset for it");
        offset_ = found->second;
      }
      offset_known_ = true;
    }
    return offset_[axis];
  }

  [[noreturn]] static void refuse_motion(int motion) {
    const std::string name = code_name('G', motion);
    if (motion == kNoMotion) refuse("axis words without a motion code");
    if (motion >= 730) refuse(name + ": a canned cycle; post the program with its single moves");
    if (motion >= 382 && motion <= 385) refuse(name + ": probing ends where the part is, not where a program can say");
    if (motion == 330 || motion == 331) refuse(name + ": spindle-synchronised motion");
    refuse(name + ": splines are not corrected; post the program with lines");
  }

  struct BlockNature {
    bool changes_modes;
    bool stops;
    bool tool_change;
  };

  void move(const Words& words, std::uint32_t begin, std::uint32_t end, BlockNature nature, ScannedChunk& chunk) {
    if (motion_ != 0 && motion_ != 10 && !arc_mode()) refuse_motion(motion_);
    if (!arc_mode() && (words.has_centre() || words.arc[3] != nullptr)) bad("I, J, K or R in a block that is no arc");
    if (cutter_)
      refuse("G41 or G42 is active: cutter radius compensation is not corrected; post the tool's centre path");
    const AxisSet known_before = known_;
    const AxisValues from = at_;
    AxisSet programmed = 0;
    for (std::size_t i = 0; i < words.axes; ++i) {
      const std::size_t axis = words.order[i];
      const Token& token = *words.axis[axis];
      const double value = scale(axis) * token.number.value();
      programmed |= only(axis);
      style_[axis] = token.style;
      if (incremental_) {
        at_[axis] += value;
        if (std::abs(at_[axis]) > kInch_mm * kFarthest) bad(std::string(1, token.letter) + " leads beyond any machine");
      } else {
        at_[axis] = value + work_zero(axis) + shift_[axis];
        known_ |= only(axis);
      }
    }
    if (holds(known_before, kTilt) && at_[kTilt] != from[kTilt]) tilt_sense_ = at_[kTilt] > from[kTilt] ? 1 : -1;
    if (holds(known_before, kTurn) && at_[kTurn] != from[kTurn]) turn_sense_ = at_[kTurn] > from[kTurn] ? 1 : -1;
    if (known_ != kAllAxes) {
      if (arc_mode() && words.motion == nullptr)
        refuse("an arc without its G2 or G3, in a place where not all axes are known");
      ++chunk.copied_moves;
      if (!incremental_) raw_since_ |= programmed;
      return;
    }
    MotionBlock block = describe(words, begin, end);
    if (arc_mode()) {
      if (known_before != kAllAxes) refuse("an arc in the block that first makes all axes known");
      block.arc = arc(words, from);
      block.arc_movable = !absolute_centre_;
      for (const Token* token : words.arc)
        if (token != nullptr)
          block.arc_word[block.arc_words++] = {begin + token->text, begin + token->end, token->number, token->style};
    }
    if (words.motion != nullptr)
      block.motion_word =
          WordPlace{begin + words.motion->text, begin + words.motion->end, words.motion->number, words.motion->style};
    block.kind = motion_ == 0 ? BlockKind::rapid : BlockKind::feed;
    block.from = from;
    block.target = at_;
    block.from_known = known_before == kAllAxes;
    block.raw_since = raw_since_;
    block.stops = nature.stops;
    block.changes_modes = nature.changes_modes || nature.tool_change;
    raw_since_ = 0;
    chunk.blocks.push_back(block);
  }

  /// Centre and sweep after LinuxCNC's rules: I J K from the begin (G91.1) or from zero (G90.1), or a radius; a full
  /// circle where the end is the begin; P turns.
  Arc arc(const Words& words, const AxisValues& from) {
    constexpr double kRadiusSlack_mm = 0.01;
    Arc arc{plane_[0], plane_[1]};
    const std::size_t a = arc.first, b = arc.second;
    const double chord_a = at_[a] - from[a], chord_b = at_[b] - from[b];
    const double chord = std::hypot(chord_a, chord_b);
    const double sense = motion_ == 30 ? 1 : -1;
    if (words.arc[plane_[2]] != nullptr) bad("an arc with a centre word that is not of its plane");
    if (const Token* radius_word = words.arc[3]) {
      if (words.has_centre()) bad("an arc with both a radius and a centre");
      const double radius = unit_mm_ * radius_word->number.value();
      if (chord == 0) bad("an arc by radius that ends where it begins");
      if (chord > 2 * std::abs(radius) + kRadiusSlack_mm) bad("an arc whose radius does not reach its end");
      const double height = std::sqrt(std::max(0.0, radius * radius - 0.25 * chord * chord));
      // Left of the chord for a counter-clockwise arc of less than half a turn.
      const double side = sense * (radius > 0 ? 1 : -1);
      arc.centre_first = from[a] + 0.5 * chord_a - side * height * chord_b / chord;
      arc.centre_second = from[b] + 0.5 * chord_b + side * height * chord_a / chord;
    } else {
      if (words.arc[a] == nullptr && words.arc[b] == nullptr) bad("an arc without centre or radius");
      const auto centre = [&](std::size_t axis) {
        const double value = words.arc[axis] != nullptr ? unit_mm_ * words.arc[axis]->number.value() : 0;
        if (!absolute_centre_) return from[axis] + value;
        if (words.arc[axis] == nullptr) bad("an arc with G90.1 wants both centre words");
        return value + work_zero(axis) + shift_[axis];
      };
      arc.centre_first = centre(a);
      arc.centre_second = centre(b);
    }
    const double begin_a = from[a] - arc.centre_first, begin_b = from[b] - arc.centre_second;
    const double end_a = at_[a] - arc.centre_first, end_b = at_[b] - arc.centre_second;
    const double radius = std::hypot(begin_a, begin_b);
    if (radius == 0) bad("an arc of radius zero");
    if (std::abs(std::hypot(end_a, end_b) - radius) > std::max(kRadiusSlack_mm, 1e-3 * radius))
      bad("an arc whose end does not lie on it");
    constexpr double kTurn_rad = 2 * std::numbers::pi;
    double sweep = std::atan2(begin_a * end_b - begin_b * end_a, begin_a * end_a + begin_b * end_b);
    if (chord == 0) sweep = 0;
    if (sense * sweep <= 1e-12) sweep += sense * kTurn_rad;
    if (const Token* turns = words.arc[4]) {
      const double whole = turns->number.value();
      if (whole < 1 || whole > 1000 || whole != std::floor(whole))
        bad("P of an arc is a whole number of turns, 1 or more");
      sweep += sense * kTurn_rad * (whole - 1);
    }
    arc.sweep_rad = sweep;
    return arc;
  }

  MotionBlock describe(const Words& words, std::uint32_t begin, std::uint32_t end) {
    MotionBlock block;
    block.line = line_;
    block.begin = begin;
    block.end = end;
    block.incremental = incremental_;
    block.tcp = settings_.tcp;
    block.words = words.axes;
    block.order = words.order;
    for (std::size_t i = 0; i < words.axes; ++i) {
      const std::size_t axis = words.order[i];
      const Token& token = *words.axis[axis];
      block.programmed |= only(axis);
      block.word[axis] = {begin + token.text, begin + token.end, token.number, token.style};
    }
    const int least = settings_.decimals;
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      const int wanted = least + (axis < 3 && unit_mm_ != 1 ? 2 : 0);
      block.decimals[axis] =
          static_cast<std::uint8_t>(std::clamp<int>(style_[axis].decimals, wanted, std::max(wanted, kFinestDecimals)));
      block.zero[axis] = work_zero(axis) + shift_[axis];
    }
    block.style = style_;
    block.unit_mm = unit_mm_;
    block.blank_before_words = words.blank_before_words;
    block.tilt_sense = tilt_sense_;
    block.turn_sense = turn_sense_;
    block.feed_mode = feed_mode_;
    if (words.feed != nullptr)
      block.feed_word =
          WordPlace{begin + words.feed->text, begin + words.feed->end, words.feed->number, words.feed->style};
    if (words.feed_mode != nullptr)
      block.feed_mode_word = WordPlace{begin + words.feed_mode->text, begin + words.feed_mode->end, {}, {}};
    block.feed = feed_mode_ == FeedMode::inverse_time && words.feed == nullptr ? 0 : feed_;
    block.feed_unit_mm = feed_unit_mm_;
    return block;
  }

  ScanSettings settings_;
  IsoTokenizer tokenize_;
  std::uint64_t line_ = 0;
  bool anything_ = false, percent_ = false, ended_ = false;

  int motion_ = kNoMotion;
  double unit_mm_ = 1;
  bool incremental_ = false;
  bool cutter_ = false;
  bool absolute_centre_ = false;                // G90.1
  std::array<std::uint8_t, 3> plane_{0, 1, 2};  // first, second and third axis of G17, G18, G19
  bool tool_length_changed_ = false;
  FeedMode feed_mode_ = FeedMode::per_minute;
  double feed_ = 0;
  double feed_unit_mm_ = 1;
  std::string system_ = "G54";
  bool offset_known_ = false;
  std::array<double, 3> offset_{};
  AxisValues shift_{}, stored_shift_{};  // G92 and G52

  AxisValues at_{};  // where the program has brought the axes, work offsets included
  AxisSet known_ = 0;
  AxisSet raw_since_ = 0;
  std::array<NumberStyle, kAxes> style_{};
  int tilt_sense_ = 1, turn_sense_ = 1;
};

}  // namespace

std::unique_ptr<ProgramScanner> linuxcnc_scanner(const ScanSettings& settings) {
  return std::make_unique<LinuxcncScanner>(settings);
}

}  // namespace trunnion
