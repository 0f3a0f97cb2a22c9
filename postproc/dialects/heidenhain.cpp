#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <span>

#include "postproc/block.h"
#include "postproc/dialects/dialects.h"
#include "postproc/program_state.h"

namespace trunnion {
namespace {

constexpr double kFastest = 1e9;

bool is_letter(char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\0' || c == '\x7f'; }

/// A piece of a Klartext block: letters, and what stands behind them.
struct Piece {
  std::string name;  ///< upper case: X, IX, FMAX, DR, SPA
  WordPlace place;   ///< in the line
  bool number = false;
  char sign = 0;          ///< + or - without a number: DR+
  bool variable = false;  ///< Q5, -QL3: not computed
  std::string variable_name;
};

/// Takes a line apart: an optional number, then pieces, a comment at its end.
class KlartextLine {
 public:
  explicit KlartextLine(std::string_view line) : line_(line) {
    std::size_t end = line.size();
    while (end > 0 && (line[end - 1] == '\n' || is_blank(line[end - 1]))) --end;
    std::size_t at = 0;
    const auto skip = [&] {
      while (at < end && is_blank(line[at])) ++at;
    };
    skip();
    while (at < end && is_digit(line[at])) ++at;
    skip();
    text_ = at;
    while (at < end) {
      if (line[at] == ';' || (line[at] == '*' && at == text_)) {
        comment_ = line.substr(at, end - at);
        break;
      }
      if (line[at] == '~') {
        ++at;
        continued_ = true;
      } else if (!is_letter(line[at])) {
        strange_ = true;
        ++at;
      } else {
        at = take(at, end);
      }
      skip();
    }
  }

  std::span<const Piece> pieces() const { return pieces_; }
  /// From the block's function to its end, in capitals.
  std::string text() const {
    std::string upper(line_.substr(std::min(text_, line_.size())));
    for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return upper;
  }
  std::string_view comment() const { return comment_; }
  bool empty() const { return pieces_.empty() && !strange_; }
  bool strange() const { return strange_; }
  std::string function() const { return pieces_.empty() ? "" : pieces_.front().name; }

 private:
  std::size_t take(std::size_t at, std::size_t end) {
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

  static bool is_sign(char c) { return c == '+' || c == '-'; }

  std::size_t value(std::size_t at, std::size_t end, Piece& piece) {
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

  std::string_view line_;
  std::size_t text_ = 0;
  std::vector<Piece> pieces_;
  std::string_view comment_;
  bool strange_ = false, continued_ = false;
};

class HeidenhainScanner : public ProgramScanner {
 public:
  explicit HeidenhainScanner(const ScanSettings& settings) : settings_(settings), state_(settings) {}

  bool scan(std::string_view line, std::uint32_t begin, ScannedChunk& chunk) override {
    ++line_;
    ++chunk.lines;
    if (ended_) return true;
    begin_ = begin;
    try {
      execute(KlartextLine(line), line, chunk);
    } catch (const LineRefused& refused) {
      chunk.refusals.push_back({line_, refused.reason, refused.kind});
      state_.forget(kAllAxes);
      return settings_.keep_going && refused.kind == Refusal::Kind::refused;
    }
    return true;
  }

 private:
  void execute(const KlartextLine& block, std::string_view line, ScannedChunk& chunk) {
    if (contains_mark(block.comment())) refuse("this program has been corrected already; correct the original");
    if (block.empty()) return;
    const std::string function = block.function();
    if (function == "L" || function == "LN" || function == "C" || function == "CR" || function == "CT" ||
        function == "CP")
      return path(block, line, chunk);
    if (function == "CC") return pole(block);
    if (function == "TOOL") return tool(block);
    if (function == "CYCL") return cycle(block);
    if (function == "PLANE") return plane(block);
    if (function == "FUNCTION") return special_function(block);
    if (function == "BEGIN" || function == "END") return begin_or_end(block);
    if (function == "M" || function == "STOP") return miscellaneous(block);
    if (function == "FN") return assignment(block);
    if (function == "CALL" || function == "SEL")
      refuse(block.text().substr(0, 9) + ": calls are not followed; post the program without them");
    if (function == "RND" || function == "CHF")
      refuse(function + ": rounds or breaks a corner; post the program with its single moves");
    if (function == "LP" || function == "CTP")
      refuse(function + ": polar coordinates; post the program with Cartesian ones");
    if (function == "APPR" || function == "DEP" || function == "LT" || function == "LCT")
      refuse(function + ": a smooth approach; post the program with its single moves");
    if (function == "FL" || function == "FLT" || function == "FC" || function == "FCT" || function == "FPOL" ||
        function == "FSELECT")
      refuse(function + ": free contours are not computed; post the program with L and C");
    if (function == "TCH" || function == "TOUCH") refuse("a touch probe cycle: it ends where the part is");
    if (function == "BLK" || function == "LBL" || function == "Q" || function == "QL" || function == "QR" ||
        function == "QS" || function == "DECLARE" || function == "RADIUS" || function == "HEIGHT")
      return;
    refuse(function + " is not known to dialect heidenhain");
  }

  // --- moves
  // ----------------------------------------------------------------------------------------------------------

  std::optional<std::size_t> axis_of(std::string_view name) const {
    if (name.size() != 1) return std::nullopt;
    for (std::size_t i = 0; i < kAxes; ++i)
      if (settings_.letters[i] == name[0]) return i;
    return std::nullopt;
  }

  WordPlace placed(WordPlace word) const {
    word.text += begin_;
    word.number += begin_;
    word.number_end += begin_;
    word.end += begin_;
    return word;
  }

  /// What a block says besides its axes.
  struct Told {
    bool rapid = false, machine = false, ends = false, stops = false, has_feed = false;
    int sense = 0;
    const Piece* radius = nullptr;
    const Piece* angle = nullptr;  // PA or IPA
    std::array<const Piece*, 3> direction{};
    bool normal = false, plane_angles = false;
    std::vector<int> m;
  };

  void path(const KlartextLine& block, std::string_view line, ScannedChunk& chunk) {
    const std::string function = block.function();
    move_.clear();
    MotionBlock& motion = move_.block;
    motion.begin = begin_;
    motion.end = begin_ + static_cast<std::uint32_t>(line.size());
    motion.blank_before_words = true;
    motion.motion_word = {begin_ + block.pieces().front().place.text, begin_ + block.pieces().front().place.end};
    if (block.strange()) bad("bytes that are no word of a block");
    const bool arc = function[0] == 'C';
    Told told;
    bool feed_of_m = false;  // M128 F1000: that F is not the block's
    for (const Piece& piece : block.pieces().subspan(1)) take(piece, arc, told, feed_of_m);
    motion.stops = told.stops;
    for (const int m : told.m) before_move(m);
    if (told.plane_angles) {
      state_.turn_to_plane("a move to Q120 ... Q122", plane_sense_);
    } else if (told.machine) {
      state_.forget(motion.words > 0 ? motion.programmed : kAllAxes);
      ++chunk.copied_moves;
    } else if (motion.words > 0 || told.direction[0] != nullptr || arc) {
      move_.kind = arc ? Move::Kind::arc : told.rapid ? Move::Kind::rapid : Move::Kind::line;
      if (arc) tell_arc(function, told);
      if (told.direction[0] != nullptr || told.direction[1] != nullptr || told.direction[2] != nullptr)
        take_direction(told);
      if (told.normal) {
        move_.has_extras = true;
        move_.extras.undividable = "a move of LN with a surface normal";
      }
      state_.move(move_, line_, chunk);
    }
    for (const int m : told.m) behind_move(m);
    if (told.ends) ended_ = true;
  }

  void take(const Piece& piece, bool arc, Told& told, bool& feed_of_m) {
    const std::string& name = piece.name;
    const bool incremental = name.size() == 2 && name[0] == 'I';
    if (const auto axis = axis_of(incremental ? name.substr(1) : name)) {
      if (piece.variable) return take_variable(piece, *axis, told);
      if (!piece.number) bad(name + " without a number");
      if (std::abs(piece.place.value.value()) > kFarthest) bad(name + " is beyond 1000000");
      move_.add(*axis, placed(piece.place), settings_.letters[*axis]);
      if (incremental) {
        move_.block.wrapped |= only(*axis);
        move_.explicit_increments |= only(*axis);
      }
    } else if (name == "F") {
      take_feed(piece, told, feed_of_m);
    } else if (name == "FMAX") {
      told.rapid = true;
    } else if (name == "FAUTO" || name == "FU" || name == "FZ" || name == "FT" || name == "FMAXT") {
      state_.feed = 0;
      told.has_feed = true;
    } else if (name == "RL" || name == "RR") {
      state_.cutter = name == "RL" ? "RL" : "RR";
    } else if (name == "R" && arc && piece.number && piece.place.value.mantissa != 0) {
      told.radius = &piece;
    } else if (name == "R") {
      if (!piece.number || piece.place.value.mantissa != 0) bad("R without a radius, or in a block that is no arc");
      state_.cutter = {};
    } else if (name == "DR") {
      told.sense = piece.sign == '+' ? 1 : piece.sign == '-' ? -1 : 0;
      if (arc) add_arc_word(piece, ArcWord::Tells::nothing_moved, 0);
    } else if (name == "PA" || name == "IPA") {
      told.angle = &piece;
    } else if (name == "TX" || name == "TY" || name == "TZ") {
      if (!piece.number) refuse(name + " is not followed by a plain number");
      told.direction[static_cast<std::size_t>(name[1] - 'X')] = &piece;
    } else if (name == "NX" || name == "NY" || name == "NZ") {
      told.normal = true;
    } else if (name == "M") {
      if (!piece.number || piece.place.value.decimals != 0) bad("M without a whole number");
      const int m = static_cast<int>(std::min<std::int64_t>(piece.place.value.mantissa, 9999));
      told.m.push_back(m);
      feed_of_m = m == 128 || m == 103 || m == 140;
      told.machine |= m == 91 || m == 92;
      told.ends |= m == 2 || m == 30;
      told.stops |= m == 0 || m == 1 || told.ends;
    } else if (name == "MB" && feed_of_m) {
      // how far M140 retracts
    } else if (name == "A" || name == "B" || name == "C" || name == "U" || name == "V" || name == "W" ||
               (incremental && std::string_view("ABCUVW").find(name[1]) != std::string_view::npos)) {
      refuse(name + ": this machine has no such axis");
    } else {
      bad(name + " is no word of a block that moves");
    }
  }

  /// Q120, Q121 and Q122 are the angles of the plane that PLANE ... STAY has left to the program.
  void take_variable(const Piece& piece, std::size_t axis, Told& told) {
    const char letter = settings_.letters[axis];
    const std::string own = "Q" + std::to_string(120 + (letter - 'A'));
    if (axis < 3 || !state_.plane_waits() || piece.variable_name != own)
      refuse(piece.name +
             " is not followed by a plain number; variables and expressions in motion words are not computed");
    told.plane_angles = true;
  }

  void take_feed(const Piece& piece, Told& told, bool feed_of_m) {
    if (piece.variable && !feed_of_m) state_.feed = 0;
    if (piece.variable || feed_of_m) return;
    if (!piece.number) bad("F without a number");
    if (told.has_feed) bad("F stands twice in one block");
    if (piece.place.value.mantissa < 0) bad("F is negative");
    if (piece.place.value.value() > kFastest) bad("F is beyond 1000000000");
    told.has_feed = true;
    state_.feed = feed_on_circumference_ ? 0 : piece.place.value.value();
    state_.feed_unit_mm = state_.unit_mm;
    move_.block.feed_word = placed(piece.place);
  }

  void add_arc_word(const Piece& piece, ArcWord::Tells tells, std::uint8_t axis) {
    move_.has_extras = true;
    move_.extras.arc_word.push_back({placed(piece.place), tells, axis});
  }

  void tell_arc(const std::string& function, const Told& told) {
    ArcTold& arc = move_.arc;
    move_.has_extras = true;
    if (function == "CT") {
      arc.tangent = true;  // of a move that is corrected itself: such an arc is not moved
      return;
    }
    if (told.sense == 0) bad(function + " wants DR+ or DR-");
    arc.sense = told.sense;
    if (function == "CR") {
      if (told.radius == nullptr) bad("CR wants R");
      arc.radius_mm = state_.unit_mm * told.radius->place.value.value();
      add_arc_word(*told.radius, ArcWord::Tells::nothing_moved, 0);
      move_.extras.arc_movable = true;
      return;
    }
    if (!pole_known_) refuse(function + ": where the pole CC stands is not known");
    for (std::size_t i = 0; i < 3; ++i)
      if (i != state_.plane[2]) arc.centre[i] = pole_[i];
    arc.centre_absolute = kLinearAxes;
    if (function == "CP") turn_about_pole(told);
  }

  /// CP PA+30 or IPA+720: round the pole, the third axis along with it.
  void turn_about_pole(const Told& told) {
    if (told.angle == nullptr || !told.angle->number) refuse("CP wants PA or IPA and a plain number");
    const std::size_t a = state_.plane[0], b = state_.plane[1];
    if (!state_.knows(a) || !state_.knows(b)) refuse("CP from where the program has not been");
    const double from_a = state_.at()[a] - state_.zero_of(a) - pole_[a];
    const double from_b = state_.at()[b] - state_.zero_of(b) - pole_[b];
    const double begin = std::atan2(from_b, from_a), radius = std::hypot(from_a, from_b);
    double sweep = Angle::degrees(told.angle->place.value.value()).in_radians();
    if (told.angle->name == "PA") {
      constexpr double turn = 2 * 3.14159265358979323846;
      sweep = std::remainder(sweep - begin, turn);
      if (told.sense * sweep <= 1e-12) sweep += told.sense * turn;
    } else if (told.sense * sweep <= 0) {
      refuse("CP whose IPA and DR have different signs");
    }
    move_.computed[a] = pole_[a] + radius * std::cos(begin + sweep);
    move_.computed[b] = pole_[b] + radius * std::sin(begin + sweep);
    move_.arc.sweep_rad = sweep;
    add_arc_word(*told.angle, ArcWord::Tells::nothing_moved, 0);
  }

  void take_direction(const Told& told) {
    if (!state_.tcp()) refuse("a tool axis by TX TY TZ without M128 or FUNCTION TCPM");
    if ((move_.block.programmed & kRotaryAxes) != 0) bad("a tool axis and a rotary axis in one block");
    std::array<WordPlace, 3> words;
    Eigen::Vector3d axis;
    for (std::size_t i = 0; i < 3; ++i) {
      if (told.direction[i] == nullptr) bad("TX, TY and TZ of a tool axis stand together");
      words[i] = placed(told.direction[i]->place);
      axis[static_cast<Eigen::Index>(i)] = words[i].value.value();
    }
    move_.tool_axis = axis;
    move_.has_extras = true;
    move_.extras.direction = words;
  }

  void pole(const KlartextLine& block) {
    pole_known_ = true;
    bool any = false;
    for (const Piece& piece : block.pieces().subspan(1)) {
      const bool incremental = piece.name.size() == 2 && piece.name[0] == 'I';
      const auto axis = axis_of(incremental ? piece.name.substr(1) : piece.name);
      if (!axis || *axis >= 3) bad(piece.name + " is no word of CC");
      if (!piece.number) refuse("CC with variables; post it with plain numbers");
      any = true;
      const double value = state_.unit_mm * piece.place.value.value();
      if (incremental && !state_.knows(*axis)) refuse("CC from where the program has not been");
      pole_[*axis] = incremental ? state_.at()[*axis] - state_.zero_of(*axis) + value : value;
    }
    if (any) return;
    // Alone it takes the place where the tool stands.
    for (std::size_t i = 0; i < 3; ++i) {
      if (i != state_.plane[2] && !state_.knows(i)) pole_known_ = false;
      pole_[i] = state_.at()[i] - state_.zero_of(i);
    }
  }

  // --- other blocks
  // ----------------------------------------------------------------------------------------------------

  void begin_or_end(const KlartextLine& block) {
    const std::string text = block.text();
    if (block.function() == "END") {
      ended_ = true;
      return;
    }
    const std::size_t last = text.find_last_not_of(" \t\r\n");
    const std::string_view whole = std::string_view(text).substr(0, last + 1);
    state_.unit_mm = whole.ends_with(" INCH") ? kInch_mm : 1;
    if (!whole.ends_with(" INCH") && !whole.ends_with(" MM")) bad("BEGIN PGM that ends neither with MM nor with INCH");
  }

  void tool(const KlartextLine& block) {
    const std::string text = block.text();
    if (text.starts_with("TOOL DEF")) return;
    const std::size_t first = text.find_first_not_of(" \t", 9);
    const bool changed =
        first != std::string::npos && (is_digit(text[first]) || text[first] == '"' || text[first] == 'Q');
    if (changed) state_.forget(kAllAxes);
    for (const Piece& piece : block.pieces()) {
      if (piece.name == "X") state_.plane = {1, 2, 0};
      if (piece.name == "Y") state_.plane = {2, 0, 1};
      if (piece.name == "Z") state_.plane = {0, 1, 2};
      if (piece.name == "F") {
        state_.feed = piece.number ? piece.place.value.value() : 0;
        state_.feed_unit_mm = state_.unit_mm;
      }
    }
  }

  void before_move(int m) {
    switch (m) {
      case 6:
        state_.forget(kAllAxes);
        break;
      case 89:
      case 99:
        refuse("M" + std::to_string(m) + ": calls a cycle; post the program with its single moves");
        break;
      case 97:
        refuse("M97: corners of small steps are moved by the control; post the tool's centre path");
        break;
      case 98:
      case 120:
      case 144:
      case 114:
        refuse("M" + std::to_string(m) + ": the control moves the path by itself; post the program without it");
        break;
      case 130:
        refuse("M130: a move in untilted coordinates; post it outside the tilted plane");
        break;
      case 94:
        state_.reduce_turn();
        break;
      case 116:
        feed_on_circumference_ = true;
        state_.feed = 0;
        break;
      case 117:
        feed_on_circumference_ = false;
        break;
      case 126:
      case 127:
        state_.turn_shortest = m == 126;
        break;
      case 128:
      case 129:
        state_.set_tcp(m == 128, "M" + std::to_string(m));
        move_.block.changes_modes = true;
        break;
      case 136:
      case 137:
        state_.feed_mode = m == 136 ? FeedMode::per_revolution : FeedMode::per_minute;
        break;
      default:
        break;
    }
  }

  void behind_move(int m) {
    if (m == 140) state_.forget(kLinearAxes);
  }

  void miscellaneous(const KlartextLine& block) {
    bool ends = false;
    for (const Piece& piece : block.pieces()) {
      if (piece.name != "M" || !piece.number) continue;
      const int m = static_cast<int>(std::min<std::int64_t>(piece.place.value.mantissa, 9999));
      before_move(m);
      behind_move(m);
      ends |= m == 2 || m == 30;
    }
    ended_ = ends;
  }

  void assignment(const KlartextLine& block) {
    const Piece& piece = block.pieces().front();
    const std::int64_t number = piece.number ? piece.place.value.mantissa : -1;
    if (number >= 9 && number <= 12)
      refuse("FN " + std::to_string(number) + ": jumps are not followed; post the program without them");
    if (number == 17) refuse("FN 17: sets the control's own data, it may move its zero");
  }

  void special_function(const KlartextLine& block) {
    const std::string text = block.text();
    if (text.starts_with("FUNCTION TCPM")) {
      if (text.find("AXIS SPAT") != std::string::npos)
        refuse("FUNCTION TCPM AXIS SPAT: rotary words are spatial angles; post it with AXIS POS");
      state_.set_tcp(true, "FUNCTION TCPM");
    } else if (text.starts_with("FUNCTION RESET TCPM")) {
      state_.set_tcp(false, "FUNCTION RESET TCPM");
    } else if (!text.starts_with("FUNCTION MODE MILL") && !text.starts_with("FUNCTION FEED") &&
               !text.starts_with("FUNCTION DWELL") && !text.starts_with("FUNCTION S-PULSE") &&
               !text.starts_with("FUNCTION CORRDATA RESET")) {
      refuse(text.substr(0, text.find_first_of(" \r\n", 9)) + " is not known to dialect heidenhain");
    }
  }

  double value(const KlartextLine& block, std::string_view name) const {
    for (const Piece& piece : block.pieces())
      if (piece.name == name) {
        if (!piece.number) refuse(std::string(name) + " is not followed by a plain number");
        return piece.place.value.value();
      }
    bad("PLANE without " + std::string(name));
  }

  void plane(const KlartextLine& block) {
    const auto says = [&](std::string_view name) {
      return std::ranges::any_of(block.pieces(), [&](const Piece& piece) { return piece.name == name; });
    };
    const bool stays = says("STAY");
    const auto turn = [](double degrees, int about) {
      return Eigen::AngleAxisd(Angle::degrees(degrees).in_radians(), Eigen::Vector3d::Unit(about)).toRotationMatrix();
    };
    if (says("RESET")) {
      state_.leave_plane();
      if (!stays) state_.forget(kRotaryAxes);
      return;
    }
    Eigen::Matrix3d rotation;
    if (says("SPATIAL")) {
      // About the fixed axes X, then Y, then Z.
      rotation = turn(value(block, "SPC"), 2) * turn(value(block, "SPB"), 1) * turn(value(block, "SPA"), 0);
    } else if (says("EULER")) {
      rotation = turn(value(block, "EULPR"), 2) * turn(value(block, "EULNU"), 0) * turn(value(block, "EULROT"), 2);
    } else {
      refuse("PLANE: the plane is told otherwise than by SPATIAL or EULER; post it so");
    }
    plane_sense_ = 0;
    for (const Piece& piece : block.pieces())
      if (piece.name == "SEQ" || piece.name == "SYM") plane_sense_ = piece.sign == '-' ? -1 : 1;
    state_.define_plane(rotation, Eigen::Vector3d::Zero(), "PLANE");
    if (!stays) state_.turn_to_plane("PLANE", plane_sense_);
  }

  /// Cycle 7 shifts the zero; some say nothing about the path; what mills or drills waits for its call.
  void cycle(const KlartextLine& block) {
    const std::string text = block.text();
    if (!text.starts_with("CYCL DEF")) refuse("CYCL CALL: a canned cycle; post the program with its single moves");
    const std::size_t digit = text.find_first_not_of(" \t", 8);
    const auto number = scan_number(text.substr(std::min(digit, text.size())));
    if (!number) bad("CYCL DEF without a number");
    const std::int64_t which = number->number.mantissa / power_of_ten(number->number.decimals);
    const bool first = number->number.decimals == 0 || number->number.mantissa % 10 == 0;
    switch (which) {
      case 7:
        if (text.find('#') != std::string::npos) refuse("cycle 7 from a datum table; give the shift by its values");
        if (!first) take_shift(block);
        break;
      case 8:
        if (!first && block.pieces().size() > 2) refuse("cycle 8: mirrors the program; post it without");
        break;
      case 10:
      case 11:
      case 26:
        if (!first && !resets(block))
          refuse("cycle " + std::to_string(which) + ": mirrors, turns or scales the program; post it without");
        break;
      case 12:
        refuse("cycle 12: calls a program; post it without");
        break;
      case 19:
        if (!first && !resets(block)) refuse("cycle 19: post the tilted plane with PLANE SPATIAL");
        if (!first) state_.leave_plane();
        break;
      case 247:
        refuse("cycle 247: selects a datum while the program runs; give each its own program and job");
        break;
      default:
        break;
    }
  }

  static bool resets(const KlartextLine& block) {
    return std::ranges::all_of(block.pieces().subspan(2),
                               [](const Piece& piece) {
                                 return !piece.variable &&
                                        (!piece.number || piece.place.value.mantissa == 0 || piece.name == "SCL");
                               }) &&
           std::ranges::none_of(
               block.pieces().subspan(2),
               [](const Piece& piece) { return piece.name == "SCL" && piece.place.value.value() != 1; }) &&
           block.pieces().size() > 0;
  }

  void take_shift(const KlartextLine& block) {
    for (const Piece& piece : block.pieces().subspan(1)) {
      const bool incremental = piece.name.size() == 2 && piece.name[0] == 'I';
      const auto axis = axis_of(incremental ? piece.name.substr(1) : piece.name);
      if (!axis) continue;
      if (!piece.number) refuse("cycle 7 with variables; give the shift by its values");
      double& shift = state_.shift()[*axis];
      const double by = state_.scale(*axis) * piece.place.value.value();
      shift = incremental ? shift + by : by;
    }
  }

  ScanSettings settings_;
  ProgramState state_;
  Move move_;
  std::uint64_t line_ = 0;
  std::uint32_t begin_ = 0;
  bool ended_ = false;
  bool feed_on_circumference_ = false;  // M116
  int plane_sense_ = 0;                 // SEQ
  bool pole_known_ = false;
  std::array<double, 3> pole_{};  // mm, in the program's coordinates
};

}  // namespace

std::unique_ptr<ProgramScanner> heidenhain_scanner(const ScanSettings& settings) {
  return std::make_unique<HeidenhainScanner>(settings);
}

}  // namespace trunnion
