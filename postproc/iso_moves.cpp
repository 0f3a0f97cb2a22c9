#include <cmath>

#include "postproc/iso_scanner.h"

// What a block of letters and numbers makes of its words where it moves.

namespace trunnion {

void IsoScanner::run_move(const IsoWords& words, ScannedChunk& chunk) {
  const bool turns = move_.tool_axis.has_value();
  if (move_.block.words == 0 && !turns && !(arc_mode() && (words.has_centre() || move_.arc.through))) {
    if (words.motion < 0) return;
    const Code code = code_of(words.motion);
    if (code == Code::clockwise || code == Code::counter_clockwise)
      bad(code_name('G', words.motion) + " without axis words");
    if (code == Code::other_motion) refuse_motion(words.motion);
    return;
  }
  if (words.optional) refuse_move("/ before a block that moves: whether it runs is not known");
  if (cycle_ >= 0) refuse_motion(cycle_);
  const Code code = code_of(motion_);
  if (words.machine_coordinates) {
    if (code != Code::rapid && code != Code::line) refuse_move("G53 without G0 or G1");
    forget_words();
    ++chunk.copied_moves;
    return;
  }
  if (code == Code::rapid) {
    move_.kind = Move::Kind::rapid;
  } else if (code == Code::line) {
    move_.kind = Move::Kind::line;
  } else if (arc_mode()) {
    move_.kind = Move::Kind::arc;
    if (words.turns_expression) refuse_move("P, the turns of an arc, is not followed by a plain number");
    if (words.dwell && words.arc[4] != nullptr && rules_.turns_letter == 'P')
      bad("P in a block with an arc and G4 or G64 has two meanings");
  } else {
    refuse_motion(motion_);
  }
  if (move_.kind == Move::Kind::arc) {
    move_.has_extras = true;
    move_.arc.sense = code == Code::counter_clockwise ? 1 : -1;
    tell_arc(words);
  } else if (!turns && (words.has_centre() || words.arc[3] != nullptr)) {
    bad("I, J, K or R in a block that is no arc");
  }
  move_.block.stops = words.stops;
  move_.block.changes_modes = words.changes_modes || words.tool_change;
  state_.move(move_, line_, chunk);
}

void IsoScanner::tell_arc(const IsoWords& words) {
  ArcTold& told = move_.arc;
  if (words.arc[state_.plane[2]] != nullptr) bad("an arc with a centre word that is not of its plane");
  if (words.arc[3] != nullptr && words.has_centre()) bad("an arc with both a radius and a centre");
  move_.extras.arc_movable = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const Token* token = words.arc[i];
    if (token == nullptr) continue;
    const bool absolute = token->counting == Counting::modal ? absolute_centre_ : token->counting == Counting::absolute;
    told.centre[i] = state_.unit_mm * value_of(*token, i).value();
    if (absolute) told.centre_absolute |= only(i);
    move_.extras.arc_word.push_back({place(*token),
                                     absolute ? ArcWord::Tells::centre : ArcWord::Tells::centre_from_begin,
                                     static_cast<std::uint8_t>(i)});
  }
  if (absolute_centre_) told.centre_absolute = kLinearAxes;
  if (words.arc[3] != nullptr) {
    told.radius_mm = state_.unit_mm * value_of(*words.arc[3], 0).value();
    move_.extras.arc_word.push_back({place(*words.arc[3])});
  }
  if (words.arc[4] != nullptr && rules_.turns_letter == 'P') {
    const double whole = words.arc[4]->value.value();
    if (whole < 1 || whole > 1000 || whole != std::floor(whole))
      bad("P of an arc is a whole number of turns, 1 or more");
    told.turns = static_cast<int>(whole) - 1;
    move_.extras.arc_word.push_back({place(*words.arc[4])});
  }
}

void IsoScanner::forget_words() { state_.forget(move_.block.words > 0 ? move_.block.programmed : kAllAxes); }

void IsoScanner::refuse_motion(int motion) const {
  const CodeEntry* found = entry(motion);
  if (found == nullptr || found->code == Code::no_motion) refuse_move("axis words without a motion code");
  refuse_move(code_name('G', motion) + ": " + found->reason);
}

}  // namespace trunnion
