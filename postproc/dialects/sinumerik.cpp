#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>

#include "postproc/dialects/dialects.h"
#include "postproc/iso_scanner.h"

namespace trunnion {
namespace sinumerik_words {
namespace {

constexpr int kThroughPoint = 9001, kTangent = 9002;  // CIP and CT among the G codes
constexpr const char* kPolar = "polar coordinates; post the program with Cartesian ones";
constexpr const char* kThread = "spindle-synchronised motion";
constexpr const char* kApproach = "a smooth approach; post the program with its single moves";

const std::vector<CodeEntry>& codes() {
  static const std::vector<CodeEntry> all = [] {
    std::vector<CodeEntry> table = {
        {0, Code::rapid},
        {10, Code::line},
        {20, Code::clockwise},
        {30, Code::counter_clockwise},
        {40, Code::dwell},
        {70, Code::refused, "an inclined axis; post the program without it"},
        {90, Code::harmless},
        {170, Code::plane_xy},
        {180, Code::plane_zx},
        {190, Code::plane_yz},
        {250, Code::alone},
        {260, Code::alone},
        {330, Code::other_motion, kThread},
        {340, Code::other_motion, kThread},
        {350, Code::other_motion, kThread},
        {400, Code::cutter_off},
        {410, Code::cutter_on},
        {420, Code::cutter_on},
        {530, Code::machine_coordinates},
        {580, Code::special},
        {590, Code::special},
        {600, Code::harmless},
        {630, Code::other_motion, kThread},
        {640, Code::harmless},
        {700, Code::inch},
        {710, Code::metric},
        {740, Code::home},
        {750, Code::home},
        {900, Code::absolute},
        {910, Code::incremental},
        {930, Code::inverse_time},
        {940, Code::per_minute},
        {950, Code::per_revolution},
        {960, Code::per_revolution},
        {961, Code::per_minute},
        {962, Code::harmless},
        {970, Code::per_revolution},
        {971, Code::per_minute},
        {1100, Code::refused, kPolar},
        {1110, Code::refused, kPolar},
        {1120, Code::refused, kPolar},
        {1530, Code::machine_coordinates},
        {2900, Code::harmless},
        {2910, Code::refused, "the control reads another dialect from here on"},
        {3310, Code::other_motion, kThread},
        {3320, Code::other_motion, kThread},
        {5000, Code::special},
        {7000, Code::inch},
        {7100, Code::metric},
        {kThroughPoint, Code::counter_clockwise},
        {kTangent, Code::counter_clockwise},
    };
    for (const int g : {54, 55, 56, 57}) table.push_back({10 * g, Code::work_offset});
    for (int g = 505; g <= 599; ++g) table.push_back({10 * g, Code::work_offset});
    for (const int g : {450, 451, 460, 461, 462, 601, 602, 603, 621, 62, 641, 642, 643, 644, 645, 810, 811, 820, 821})
      table.push_back({10 * g, Code::harmless});
    for (const int g : {140, 141, 142, 143, 147, 148, 247, 248, 340, 341, 347, 348})
      table.push_back({10 * g, Code::refused, kApproach});
    return table;
  }();
  return all;
}

const IsoRules kRules = {.dialect = "sinumerik",
                         .syntax = {.bracket_comments = false, .names = true},
                         .harmless_letters = "EHNQST",
                         .harmless_expressions = "SDHTNE",
                         .first_motion = 10,
                         .dwell_takes_feed = true,
                         .machine_feed_below_tenths = 1000};

// Names that say nothing about where the tool goes.
constexpr std::string_view kHarmlessNames[] = {
    "MSG",         "STOPRE",    "SOFT",         "BRISK",    "DRIVE",   "SOFTA",    "BRISKA",   "FFWON",  "FFWOF",
    "COMPON",      "COMPCURV",  "COMPCAD",      "COMPSURF", "COMPOF",  "UPATH",    "SPATH",    "ORISON", "ORISOF",
    "ORIRESET",    "DIAMOF",    "FGROUP",       "FNORM",    "FLIN",    "CFC",      "CFTCP",    "CFIN",   "CDON",
    "CDOF",        "CDOF2",     "NORM",         "KONT",     "KONTC",   "KONTT",    "CYCLE832", "PROC",   "WORKPIECE",
    "GROUP_BEGIN", "GROUP_END", "GROUP_ADDEND", "WALIMON",  "WALIMOF", "CPRECON",  "CPRECOF",  "ADIS",   "ADISPOS",
    "WAITM",       "WAITP",     "SAVE",         "DISPLOF",  "SETAL",   "FENDNORM", "LFON",     "LFOF",   "TOWSTD",
    "TOROTOF",     "STARTFIFO", "STOPFIFO",     "PAROTOF",
};
// Assignments likewise.
constexpr std::string_view kHarmlessValues[] = {"SPOS", "SPOSA", "CTOL", "OTOL", "ATOL",
                                                "LIMS", "FZ",    "FFW",  "ADIS", "ADISPOS"};
constexpr std::string_view kSplines[] = {"ASPLINE", "BSPLINE", "CSPLINE", "POLY",
                                         "INVCW",   "INVCCW",  "OEMIPO1", "OEMIPO2"};
constexpr std::string_view kFlow[] = {
    "IF",      "ELSE",   "ENDIF",   "GOTO",    "GOTOF",    "GOTOB",   "GOTOC", "GOTOS", "WHILE", "ENDWHILE",
    "FOR",     "ENDFOR", "LOOP",    "ENDLOOP", "REPEAT",   "REPEATB", "UNTIL", "CASE",  "CALL",  "PCALL",
    "EXTCALL", "MCALL",  "ISOCALL", "WHEN",    "WHENEVER", "EVERY",   "DO",    "ID",    "IDS",   "FROM"};
constexpr std::string_view kCorner[] = {"RND", "RNDM", "CHF", "CHR", "FRC", "FRCM"};
constexpr std::string_view kMapped[] = {"ROT",   "AROT",   "ROTS",   "AROTS",   "CROTS",
                                        "SCALE", "ASCALE", "MIRROR", "AMIRROR", "RPL"};

template <std::size_t N>
bool among(const std::string_view (&names)[N], std::string_view name) {
  return std::ranges::find(names, name) != std::end(names);
}

/// A letter and digits: M3, S1, R10.
bool numbered(std::string_view name, std::string_view letters) {
  return name.size() > 1 && letters.find(name[0]) != std::string_view::npos &&
         std::ranges::all_of(name.substr(1), [](char c) { return c >= '0' && c <= '9'; });
}

/// The arguments of a call, blanks around them gone; texts in quotes count as one.
std::vector<std::string> arguments(std::string_view call) {
  std::vector<std::string> list;
  const std::size_t open = call.find('(');
  if (open == std::string_view::npos) return list;
  std::string one;
  bool quoted = false, any = false;
  for (const char c : call.substr(open + 1)) {
    if (c == '"') quoted = !quoted;
    if (!quoted && c == ')') break;
    any |= c != ' ' && c != '\t';
    if (!quoted && c == ',') {
      list.push_back(std::move(one));
      one.clear();
    } else if (quoted || (c != ' ' && c != '\t')) {
      one += c;
    }
  }
  if (any || !list.empty()) list.push_back(std::move(one));
  return list;
}

class SinumerikScanner : public IsoScanner {
 public:
  explicit SinumerikScanner(const ScanSettings& settings) : IsoScanner(settings, kRules, codes()) {}

 protected:
  bool take_other(std::string_view text) override { return text[0] == ':' && text.size() > 1; }

  void take_letter(const Token& token, IsoWords& words) override {
    if (const auto axis = axis_of(token.letter)) {
      move_.block.wrapped |= only(*axis);
      if (token.counting == Counting::incremental) move_.explicit_increments |= only(*axis);
      if (token.counting == Counting::shortest) move_.shortest |= only(*axis);
      if (token.counting == Counting::one_way)
        refuse_move(std::string(1, token.letter) +
                    "=ACP() or ACN(): a correction could send the axis round once more; post it with DC() or without");
      return;
    }
    if (token.letter == 'D') {
      state_.forget(only(2));  // another tool length
    } else if (token.letter == 'L') {
      refuse("L" + std::to_string(token.value.mantissa) + ": subprogram call; post the program without it");
    } else if (token.letter < 'I' || token.letter > 'K') {
      IsoScanner::take_letter(token, words);
    }
  }

  void take_expression(const Token& token, IsoWords& words) override {
    if (token.letter != 0) return IsoScanner::take_expression(token, words);
    const std::string name = upper_name(token);
    if (numbered(name, "RMSHTD") || among(kHarmlessValues, name)) return;
    refuse_move(name +
                "= is not followed by a plain number; variables and expressions in motion words are not computed");
  }

  void take_name(std::string_view line, const Token& token, IsoWords& words) override {
    const std::string name = upper_name(token);
    if (token.kind == TokenKind::word) return take_value(name, token);
    if (among(kHarmlessNames, name)) return;
    words.changes_state |= name != "DEF" && name != "EXTERN";
    if (name == "ORIAXES") {
      state_.turning = ToolTurning::axes;
    } else if (name == "ORIVECT" || name == "ORIPLANE") {
      state_.turning = ToolTurning::great_circle;
    } else if (name == "ORIWKS" || name == "ORIMKS") {
      vectors_of_machine_ = name == "ORIMKS";
    } else if (name == "DEF" || name == "EXTERN") {
      words.rest_ignored = true;
    } else if (name == "TRAORI" || name == "TRAFOOF") {
      state_.set_tcp(name == "TRAORI", name);
      words.changes_modes = true;
    } else if (name == "CIP" || name == "CT") {
      if (words.g_count == words.g.size()) bad("more than 16 G codes in one block");
      words.g[words.g_count++] = name == "CIP" ? kThroughPoint : kTangent;
      move_.block.motion_word = text_place(token);
    } else if (name == "SUPA") {
      words.machine_coordinates = true;
    } else if (name == "TRANS" || name == "ATRANS" || among(kMapped, name)) {
      frame_ = name;
    } else if (name == "CYCLE800") {
      take_plane(arguments(line.substr(token.text, token.end - token.text)));
      words.changes_modes = true;
    } else if (name == "RET") {
      words.ends = words.stops = true;
    } else if (among(kSplines, name)) {
      refuse(name + ": curves are not corrected; post the program with lines and arcs");
    } else if (among(kFlow, name)) {
      refuse(name + ": jumps, loops and calls are not followed; post the program without them");
    } else if (name == "DIAMON" || name == "DIAM90") {
      refuse(name + ": diameter programming belongs to a lathe");
    } else {
      refuse(name +
             ": a cycle, a subprogram or a function that is not known to dialect sinumerik; post the program with "
             "its single moves");
    }
  }

  void take_m(int m, IsoWords& words) override {
    if (m == 6) words.tool_change = true;
    if (m == 2 || m == 17 || m == 30) words.ends = true;
    words.stops |= m == 0 || m == 1 || words.ends;
  }

  void take_code(int g, IsoWords& words) override {
    if (g == 5000) {
      state_.select_offset("G500");
      words.changes_modes = true;
    } else if (move_.block.words > 0) {
      refuse(code_name('G', g) + ": moves the zero of single axes; post it with TRANS");
    } else {
      if (g == 580 || g == 590) assumptions_ |= only(Assumption::offset_without_words);
      state_.select_offset(code_name('G', g));
      words.changes_modes = true;
    }
  }

  bool take_block(IsoWords& words, ScannedChunk&) override {
    if (words.arc[3] != nullptr) bad("R is no word of a move; a radius is CR=");
    if (words.dwell || words.alone >= 0) return true;
    if (!frame_.empty()) {
      take_frame();
      return true;
    }
    if (axis_words_ != 0) take_direction();
    return false;
  }

  void tell_arc(const IsoWords& words) override {
    ArcTold& told = move_.arc;
    if (motion() == kTangent) {
      told.tangent = true;
      move_.extras.arc_name = "CT";  // it goes on from a move that is corrected itself: such an arc is not moved
      return;
    }
    if (motion() == kThroughPoint) {
      told.through = through_;
      move_.extras.arc_name = "CIP";
      move_.extras.arc_movable = true;
    } else {
      if (cr_) told.radius_mm = state_.unit_mm * cr_->value.value();
      if (cr_ && words.has_centre()) bad("an arc with both a radius and a centre");
      IsoScanner::tell_arc(words);
    }
    for (const WordPlace& word : arc_words_) move_.extras.arc_word.push_back({word});
    if (motion() == kThroughPoint) {
      if (point_words_ == 0) bad("CIP wants I1=, J1= or K1=");
      for (std::size_t i = 0; i < 3; ++i) {
        if (!holds(point_words_, i)) {
          (*told.through)[i] = state_.at()[i] - state_.zero_of(i);
          continue;
        }
        const bool from_begin = state_.incremental;
        double place = state_.unit_mm * point_[i].value.value();
        if (from_begin) place += state_.at()[i] - state_.zero_of(i);
        (*told.through)[i] = place;
        move_.extras.arc_word.push_back({point_[i], from_begin ? ArcWord::Tells::nothing_moved : ArcWord::Tells::point,
                                         static_cast<std::uint8_t>(i)});
      }
    }
    if (turns_) {
      if (turns_->decimals != 0 || turns_->mantissa < 0 || turns_->mantissa > 999) bad("TURN= from 0 to 999 is wanted");
      told.turns = static_cast<int>(turns_->mantissa);
    }
  }

  void begin_block() override {
    frame_.clear();
    axis_words_ = point_words_ = 0;
    arc_words_.clear();
    cr_.reset();
    turns_.reset();
    through_ = std::array<double, 3>{};
  }

 private:
  std::string upper_name(const Token& token) const {
    std::string name(name_of(token));
    for (char& c : name) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return name;
  }

  /// NAME=number.
  void take_value(const std::string& name, const Token& token) {
    if (name.size() == 2 && name[1] == '3' && name[0] >= 'A' && name[0] <= 'C') {
      const std::size_t i = static_cast<std::size_t>(name[0] - 'A');
      if (holds(axis_words_, i)) bad(name + " stands twice in one block");
      axis_words_ |= only(i);
      direction_[i] = place(token);
      move_.block.blank_before_words = token.text > token.begin;
    } else if (name == "CR") {
      cr_ = place(token);
      arc_words_.push_back(*cr_);
    } else if (name == "TURN") {
      turns_ = token.value;
      arc_words_.push_back(place(token));
    } else if (name == "I1" || name == "J1" || name == "K1") {
      const std::size_t i = static_cast<std::size_t>(name[0] - 'I');
      if (token.counting != Counting::modal) refuse_move(name + "=AC() or IC(); post it plain");
      point_words_ |= only(i);
      point_[i] = place(token);
    } else if (name == "AR" || name == "AP" || name == "RP") {
      refuse_move(name + "=: an angle or polar coordinates; post the arc with its end and centre");
    } else if (among(kCorner, name)) {
      (name == "RNDM" || name == "FRCM" ? refuse : refuse_move)(
          name + "=: rounds or breaks a corner; post the program with its single moves");
    } else if (!numbered(name, "RMSHTD") && !among(kHarmlessValues, name)) {
      refuse(name + "=: this machine has no such axis, nor dialect sinumerik such a word");
    }
  }

  /// TRANS and ATRANS with their words, and what ends them.
  void take_frame() {
    const MotionBlock& block = move_.block;
    if (among(kMapped, frame_)) {
      if (block.words > 0 || frame_ == "RPL" || frame_[0] == 'A' || frame_[0] == 'C')
        refuse(frame_ + ": turns, scales or mirrors the program; post it without");
    }
    if (frame_ != "ATRANS") {
      if (state_.in_plane()) refuse(frame_ + " in a plane of CYCLE800; use ATRANS");
      state_.shift() = {};
    }
    for (std::size_t i = 0; i < block.words; ++i) {
      const std::size_t axis = block.order[i];
      state_.shift()[axis] += state_.scale(axis) * block.word[axis].value.value();
    }
  }

  /// A3= B3= C3=.
  void take_direction() {
    if (axis_words_ != 0b111) bad("A3=, B3= and C3= of a tool axis stand together");
    if (!state_.tcp()) refuse_move("a tool axis by A3= B3= C3= without TRAORI");
    if (vectors_of_machine_) refuse_move("a tool axis by A3= B3= C3= under ORIMKS does not turn with the workpiece");
    if ((move_.block.programmed & kRotaryAxes) != 0) bad("a tool axis and a rotary axis in one block");
    move_.tool_axis =
        Eigen::Vector3d(direction_[0].value.value(), direction_[1].value.value(), direction_[2].value.value());
    move_.has_extras = true;
    move_.extras.direction = direction_;
  }

  /// CYCLE800(_FR, _TC, _ST, _MODE, _X0, _Y0, _Z0, _A, _B, _C, _X1, _Y1, _Z1, _DIR ...): a plane turned about its own
  /// axes one after the other, in the order that _MODE tells two bits each.
  void take_plane(const std::vector<std::string>& list) {
    if (list.empty()) return state_.leave_plane();
    const auto value = [&](std::size_t i) {
      if (i >= list.size() || list[i].empty()) return 0.0;
      const auto scanned = scan_number(list[i]);
      if (!scanned || scanned->length != list[i].size())
        refuse("CYCLE800: '" + list[i] + "' is not a plain number; variables and expressions are not computed");
      return scanned->number.value();
    };
    const int state = static_cast<int>(value(2)), mode = static_cast<int>(value(3));
    if (state % 10 != 0) refuse("CYCLE800: a plane that adds to another; post it as a new one");
    if (mode >> 6 != 0) refuse("CYCLE800: the plane is not told axis by axis; post it so (_MODE 57, for one)");
    if (value(13) == 0) refuse("CYCLE800 without _DIR, or with 0, does not turn the axes; post it with -1 or 1");
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Eigen::Vector3d before, behind;
    for (int i = 0; i < 3; ++i) {
      const int about = (mode >> (2 * i)) & 3;
      const double angle = Angle::degrees(value(7 + static_cast<std::size_t>(i))).in_radians();
      if (about == 0 && angle != 0) refuse("CYCLE800: _MODE names no axis for one of the angles");
      if (about != 0)
        rotation = rotation * Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(about - 1)).toRotationMatrix();
      before[i] = state_.unit_mm * value(4 + static_cast<std::size_t>(i));
      behind[i] = state_.unit_mm * value(10 + static_cast<std::size_t>(i));
    }
    state_.define_plane(rotation, before + rotation * behind, "CYCLE800");
    state_.turn_to_plane("CYCLE800");
  }

  bool vectors_of_machine_ = false;  // ORIMKS
  std::string frame_;                // TRANS and its like in this block
  AxisSet axis_words_ = 0, point_words_ = 0;
  std::array<WordPlace, 3> direction_{}, point_{};
  std::optional<WordPlace> cr_;
  std::optional<Decimal> turns_;
  std::vector<WordPlace> arc_words_;
  std::optional<std::array<double, 3>> through_;
};

}  // namespace
}  // namespace sinumerik_words

std::unique_ptr<ProgramScanner> sinumerik_scanner(const ScanSettings& settings) {
  using namespace sinumerik_words;
  return std::make_unique<SinumerikScanner>(settings);
}

}  // namespace trunnion
