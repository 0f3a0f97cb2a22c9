#include <algorithm>
#include <cmath>
#include <numbers>

#include "postproc/dialects/dialects.h"
#include "postproc/dialects/heidenhain_scanner.h"

namespace trunnion {
namespace {

/// M codes of spindle, coolant, stops and the like.
bool says_nothing_of_the_path(std::int64_t m) {
  return m <= 9 ? m != 2 && m != 6 : m == 13 || m == 14 || m == 19 || m == 103 || (m >= 109 && m <= 111);
}

bool only_says_nothing_of_the_path(const KlartextLine& block) {
  return std::ranges::all_of(block.pieces(), [](const Piece& piece) {
    return piece.name == "M" && piece.number && says_nothing_of_the_path(piece.place.value.mantissa);
  });
}

}  // namespace

bool HeidenhainScanner::scan(std::string_view line, std::uint32_t begin, ScannedChunk& chunk) {
  ++line_;
  ++chunk.lines;
  if (ended_ || lost_) return true;
  begin_ = begin;
  codes_followed_ = false;
  const KlartextLine block(line);
  try {
    execute(block, line, chunk);
  } catch (const LineRefused& refused) {
    lost_ = refused.lasting || !follow_codes(block);
    chunk.refusals.push_back({line_, refused.reason + (settings_.keep_going && lost_ ? kCopiedToEnd : ""), refused.kind,
                              lost_ ? Refusal::Behind::copied : Refusal::Behind::axes_unknown});
    state_.forget(kAllAxes);
    return settings_.keep_going && refused.kind == Refusal::Kind::refused;
  }
  return true;
}

/// What a block that was refused says beside its move: false where modes are no longer known.
bool HeidenhainScanner::follow_codes(const KlartextLine& block) {
  if (codes_followed_) return true;
  state_.feed = 0;
  pole_known_ = false;
  return std::ranges::none_of(block.pieces(), [](const Piece& piece) {
    return piece.name == "RL" || piece.name == "RR" ||
           (piece.name == "M" && (!piece.number || !says_nothing_of_the_path(piece.place.value.mantissa)));
  });
}

void HeidenhainScanner::execute(const KlartextLine& block, std::string_view line, ScannedChunk& chunk) {
  if (contains_mark(block.comment())) refuse_corrected();
  if (block.empty()) return;
  const std::string function = block.function();
  if (block.optional() && function != "BLK" && function != "STOP" && !only_says_nothing_of_the_path(block))
    refuse("/ before a block: whether it runs is not known");
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
    refuse_move(function + ": rounds or breaks a corner; post the program with its single moves");
  if (function == "LP" || function == "CTP")
    refuse_move(function + ": polar coordinates; post the program with Cartesian ones");
  if (function == "APPR" || function == "DEP" || function == "LT" || function == "LCT")
    refuse_move(function + ": a smooth approach; post the program with its single moves");
  if (function == "FL" || function == "FLT" || function == "FC" || function == "FCT" || function == "FPOL" ||
      function == "FSELECT")
    refuse_move(function + ": free contours are not computed; post the program with L and C");
  if (function == "TCH" || function == "TOUCH") refuse_move("a touch probe cycle: it ends where the part is");
  if (function == "BLK" || function == "LBL" || function == "Q" || function == "QL" || function == "QR" ||
      function == "QS" || function == "DECLARE" || function == "RADIUS" || function == "HEIGHT")
    return;
  refuse(function + " is not known to dialect heidenhain");
}

std::optional<std::size_t> HeidenhainScanner::axis_of(std::string_view name) const {
  if (name.size() != 1) return std::nullopt;
  for (std::size_t i = 0; i < kAxes; ++i)
    if (settings_.letters[i] == name[0]) return i;
  return std::nullopt;
}

WordPlace HeidenhainScanner::placed(WordPlace word) const {
  word.text += begin_;
  word.number += begin_;
  word.number_end += begin_;
  word.end += begin_;
  return word;
}

void HeidenhainScanner::path(const KlartextLine& block, std::string_view line, ScannedChunk& chunk) {
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
  codes_followed_ = true;
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
  if (told.has_feed && state_.unit_mm != 1) chunk.assumptions |= only(Assumption::feed_in_tenths_of_inch);
  for (const int m : told.m) behind_move(m);
  if (told.ends) ended_ = true;
}

void HeidenhainScanner::take(const Piece& piece, bool arc, Told& told, bool& feed_of_m) {
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
    if (!piece.number) refuse_move(name + " is not followed by a plain number");
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
    refuse_move(name + ": this machine has no such axis");
  } else {
    bad(name + " is no word of a block that moves");
  }
}

void HeidenhainScanner::take_variable(const Piece& piece, std::size_t axis, Told& told) {
  const char letter = settings_.letters[axis];
  const std::string own = "Q" + std::to_string(120 + (letter - 'A'));
  if (axis < 3 || !state_.plane_waits() || piece.variable_name != own)
    refuse_move(piece.name +
                " is not followed by a plain number; variables and expressions in motion words are not computed");
  told.plane_angles = true;
}

void HeidenhainScanner::take_feed(const Piece& piece, Told& told, bool feed_of_m) {
  if (piece.variable && !feed_of_m) state_.feed = 0;
  if (piece.variable || feed_of_m) return;
  if (!piece.number) bad("F without a number");
  if (told.has_feed) bad("F stands twice in one block");
  if (piece.place.value.mantissa < 0) bad("F is negative");
  if (piece.place.value.value() > kFastest) bad("F is beyond 1000000000");
  told.has_feed = true;
  state_.feed = feed_on_circumference_ ? 0 : piece.place.value.value();
  state_.feed_unit_mm = feed_unit_mm();
  move_.block.feed_word = placed(piece.place);
}

/// F of a program in inches counts tenths of an inch.
double HeidenhainScanner::feed_unit_mm() const { return state_.unit_mm == 1 ? 1 : kInch_mm / 10; }

void HeidenhainScanner::add_arc_word(const Piece& piece, ArcWord::Tells tells, std::uint8_t axis) {
  move_.has_extras = true;
  move_.extras.arc_word.push_back({placed(piece.place), tells, axis});
}

void HeidenhainScanner::tell_arc(const std::string& function, const Told& told) {
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
  if (!pole_known_) refuse_move(function + ": where the pole CC stands is not known");
  for (std::size_t i = 0; i < 3; ++i)
    if (i != state_.plane[2]) arc.centre[i] = pole_[i];
  arc.centre_absolute = kLinearAxes;
  if (function == "CP") turn_about_pole(told);
}

void HeidenhainScanner::turn_about_pole(const Told& told) {
  if (told.angle == nullptr || !told.angle->number) refuse_move("CP wants PA or IPA and a plain number");
  const std::size_t a = state_.plane[0], b = state_.plane[1];
  if (!state_.knows(a) || !state_.knows(b)) refuse_move("CP from where the program has not been");
  const double from_a = state_.at()[a] - state_.zero_of(a) - pole_[a];
  const double from_b = state_.at()[b] - state_.zero_of(b) - pole_[b];
  const double begin = std::atan2(from_b, from_a), radius = std::hypot(from_a, from_b);
  double sweep = Angle::degrees(told.angle->place.value.value()).in_radians();
  if (told.angle->name == "PA") {
    constexpr double turn = 2 * std::numbers::pi;
    sweep = std::remainder(sweep - begin, turn);
    if (told.sense * sweep <= 1e-12) sweep += told.sense * turn;
  } else if (told.sense * sweep <= 0) {
    refuse_move("CP whose IPA and DR have different signs");
  }
  move_.computed[a] = pole_[a] + radius * std::cos(begin + sweep);
  move_.computed[b] = pole_[b] + radius * std::sin(begin + sweep);
  move_.arc.sweep_rad = sweep;
  add_arc_word(*told.angle, ArcWord::Tells::nothing_moved, 0);
}

void HeidenhainScanner::take_direction(const Told& told) {
  if (!state_.tcp()) refuse_move("a tool axis by TX TY TZ without M128 or FUNCTION TCPM");
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

void HeidenhainScanner::pole(const KlartextLine& block) {
  pole_known_ = true;
  bool any = false;
  for (const Piece& piece : block.pieces().subspan(1)) {
    const bool incremental = piece.name.size() == 2 && piece.name[0] == 'I';
    const auto axis = axis_of(incremental ? piece.name.substr(1) : piece.name);
    if (!axis || *axis >= 3) bad(piece.name + " is no word of CC");
    if (!piece.number) refuse_move("CC with variables; post it with plain numbers");
    any = true;
    const double value = state_.unit_mm * piece.place.value.value();
    if (incremental && !state_.knows(*axis)) refuse_move("CC from where the program has not been");
    pole_[*axis] = incremental ? state_.at()[*axis] - state_.zero_of(*axis) + value : value;
  }
  if (any) return;
  // Alone it takes the place where the tool stands.
  for (std::size_t i = 0; i < 3; ++i) {
    if (i != state_.plane[2] && !state_.knows(i)) pole_known_ = false;
    pole_[i] = state_.at()[i] - state_.zero_of(i);
  }
}

std::unique_ptr<ProgramScanner> heidenhain_scanner(const ScanSettings& settings) {
  return std::make_unique<HeidenhainScanner>(settings);
}

}  // namespace trunnion
