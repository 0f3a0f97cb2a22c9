#include "postproc/chunk_writer.h"

#include <algorithm>
#include <cmath>

#include "error.h"
#include "postproc/tool_axis.h"

namespace trunnion {
namespace {

using Eigen::Vector3d;

constexpr double kSameDuration = 0.02;  // of a block's time: what a correction of microns may change
constexpr double kShortestTime_s = 0.001, kLongestTime_s = 999.999;  // of FT
constexpr int kTimeDecimals = 4;
constexpr int kDirectionDecimals = 7;  // a tenth of a microradian

double unit(const MotionBlock& block, std::size_t axis) { return axis < 3 ? block.unit_mm : 1; }

/// `largest`, or the length of `v` if that is more: the root is for the few that are.
void raise_to(double& largest, const Vector3d& v) {
  if (const double square = v.squaredNorm(); square > largest * largest) largest = std::sqrt(square);
}

bool by_vectors(const MotionBlock& block) { return block.extras && block.extras->direction_in_effect; }

}  // namespace

CorrectedChunk ChunkWriter::write(std::string_view text, const ScannedChunk& scanned) {
  block_text_.begin(text);
  block_text_.out().counts.lines = scanned.lines;
  block_text_.out().counts.copied_moves = scanned.copied_moves;
  block_text_.out().counts.untimed_moves = scanned.untimed_moves;
  block_text_.out().counts.first_untimed_line = scanned.first_untimed_line;
  block_text_.out().counts.assumptions = scanned.assumptions;
  block_text_.out().refusals = scanned.refusals;
  if (!keep_going_) {
    last_ = nullptr;
    ticks_ = {};
    lines_since_arc_ = false;
    if (const auto& before = scanned.before) {
      remember(solver_.solved(*before, before->target));
      ticks_ = last_->ticks;
      ticks_unit_mm_ = before->unit_mm;
      lines_since_arc_ =
          before->arc() != nullptr && !solver_.moved_arc(*before, solver_.solved(*before, before->from).ticks, *last_);
    }
  }
  for (const MotionBlock& block : scanned.blocks) {
    try {
      block.kind == BlockKind::set_position ? set_position(block) : correct(block);
      continue;
    } catch (const RangeError& error) {
      block_text_.out().refusals.push_back({block.line, error.what(), Refusal::Kind::out_of_range});
    } catch (const RefusalError& error) {
      block_text_.out().refusals.push_back({block.line, error.what(), Refusal::Kind::refused});
    }
    if (!keep_going_) break;
    if (block.arc() != nullptr && lines_since_arc_ && !block.motion_word.stands()) {
      NewFeed code;
      code.arc_code = block.arc()->sweep_rad < 0 ? '2' : '3';
      block_text_.rewrite(block, {}, code);
    }
    if (block.arc() != nullptr || block.motion_word.stands()) lines_since_arc_ = false;
    for (std::size_t i = 0; i < kAxes; ++i)
      if (holds(block.programmed, i) && !holds(block.incremental, i)) ticks_[i] = {};
    last_ = nullptr;
  }
  std::ranges::stable_sort(block_text_.out().refusals, {}, &Refusal::line);
  return block_text_.finish();
}

Ticks ChunkWriter::ticks_before(const MotionBlock& block) const {
  Ticks ticks = ticks_;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (holds(block.raw_since, i)) ticks[i] = {};
    if (i < 3 && ticks_unit_mm_ != block.unit_mm && ticks[i].mantissa != 0)
      ticks[i] = rounded(ticks[i].value() * ticks_unit_mm_ / block.unit_mm, block.decimals[i]);
  }
  return ticks;
}

NewWords ChunkWriter::words(const MotionBlock& block, const Solution& end, bool final, Pen& pen) const {
  NewWords words;
  const bool vectors = by_vectors(block);
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (i >= kTilt && (vectors || block.rotary_fixed)) break;
    const bool programmed = holds(block.programmed, i);
    const bool moves = pen.lines && end.programmed[i] != (*pen.last_place)[i];
    if (!programmed && !moves && same_value(end.ticks[i], pen.last[i])) continue;
    const bool incremental = holds(block.incremental, i);
    if (programmed && final) {
      Decimal value = block.word[i].value + end.ticks[i];
      if (incremental) {
        const Decimal whole = value - pen.before[i];
        value = whole - pen.moved[i];
        pen.moved[i] = whole;
      }
      words[i] = value;
    } else {
      // Inside the block no digits are given: the place as it is solved, rounded once.
      const double change = i < 3
                                ? into_frame(block, end.linear.change_mm)[static_cast<Eigen::Index>(i)] / block.unit_mm
                                : end.ticks[i].value();
      const double from = incremental ? block.from[i] : block.zero[i];
      const double place = (end.programmed[i] - from) / unit(block, i) + change;
      if (!incremental) {
        words[i] = rounded(place, block.decimals[i]);
      } else {
        const Decimal whole =
            final ? end.ticks[i] - pen.before[i] : rounded(place - pen.before[i].value(), block.decimals[i]);
        words[i] = whole - pen.moved[i];
        pen.moved[i] = whole;
      }
    }
    if (holds(block.in_turn, i)) {
      const std::int64_t turn = 360 * power_of_ten(words[i]->decimals);
      words[i]->mantissa = ((words[i]->mantissa % turn) + turn) % turn;
    }
  }
  if (vectors) direction_words(block, end, final, pen, words);
  pen.last = end.ticks;
  pen.last_place = &end.programmed;
  return words;
}

/// The tool axis at the corrected angles, as the program's frame sees it.
void ChunkWriter::direction_words(const MotionBlock& block, const Solution& end, bool final, const Pen& pen,
                                  NewWords& words) const {
  const KinematicChain& chain = solver_.corrector(block).chain();
  const auto& programmed = block.extras->direction;
  const bool moves = programmed && !final;
  if (!programmed && same_value(end.ticks[kTilt], pen.last[kTilt]) && same_value(end.ticks[kTurn], pen.last[kTurn]))
    return;
  const Vector3d sent = into_frame(block, tool_axis_w(chain, end.commanded.rotary));
  const Vector3d meant = into_frame(
      block, tool_axis_w(chain, {Angle::degrees(end.programmed[kTilt]), Angle::degrees(end.programmed[kTurn])}));
  double length = 1;
  if (programmed && final) {
    length = 0;
    for (const WordPlace& word : *programmed) length += word.value.value() * word.value.value();
    length = std::sqrt(length);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Index axis = static_cast<Eigen::Index>(i);
    words[kAxes + i] = programmed && final
                           ? (*programmed)[i].value + rounded(length * (sent - meant)[axis], kDirectionDecimals)
                           : rounded(moves || !programmed ? sent[axis] : meant[axis], kDirectionDecimals);
  }
}

NewFeed ChunkWriter::new_feed(const MotionBlock& block, const Ticks& before, const Ticks& after, std::size_t pieces,
                              std::size_t lines) const {
  if (block.kind != BlockKind::feed) return {};
  const double n = static_cast<double>(pieces);
  if (block.feed_mode == FeedMode::inverse_time) {
    if (lines == 1) return {};
    if (block.feed <= 0) throw RefusalError("F is not known: with G93 every block that moves needs its own");
    return {.word = feed_decimal(block.feed * n)};
  }
  if (!block.from_known || block.arc() != nullptr || turn2_deg2(block.from, block.target) == 0) return {};
  if (text_.feed_over_all_axes && !block.tcp && !block.straight_on_part) return {};
  AxisValues to = block.target;
  double step2_mm2 = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double step = (after[i] - before[i]).value() * block.unit_mm;
    step2_mm2 += step * step;
    to[i] += step;
  }
  // F runs along X Y Z where any of them moves, else along the rotary axes in degrees.
  const double nominal2 = length2_mm2(block.from, block.target);
  if (step2_mm2 == 0 || step2_mm2 < squared(kSameDuration) * nominal2) return {};
  const double nominal = std::sqrt(nominal2), corrected = length_mm(block.from, to);
  if (nominal > 0 && std::abs(corrected / nominal - 1) < kSameDuration) return {};
  if (block.feed_mode == FeedMode::per_revolution)
    throw RefusalError("a turn of the rotary axes in G95 whose X Y Z correction would change its duration");
  if (block.feed <= 0) throw RefusalError("F is not known, so the duration of this turn cannot be kept");
  const double minutes =
      nominal > 0 ? nominal / (block.feed * block.feed_unit_mm) : turn_deg(block.from, block.target) / block.feed;
  if (!text_.time_in_seconds) return {.word = feed_decimal(n / minutes), .timed = true};
  const double seconds = 60 * minutes / n;
  if (seconds < kShortestTime_s) return {};  // shorter than any cycle of a control: F alone does no harm
  if (seconds > kLongestTime_s)
    throw RefusalError("the duration of this turn, " + text_of(seconds, 4) + " s, is beyond what FT can say");
  return {.word = rounded(seconds, kTimeDecimals), .timed = true};
}

void ChunkWriter::remember(const Solution& solution) {
  last_ = last_ == &kept_[0] ? &kept_[0] : &kept_[1];
  *last_ = solution;
}

/// The correction at the block's begin, where an axis turns round there and the correction leaps with its sense. What
/// the axis loses is then taken up by a piece of its own: spread over the block it would be wrong by nearly all of it
/// on the way. A block that cannot be divided keeps its one piece, and what that leaves is counted.
std::optional<Solution> ChunkWriter::taken_up(const MotionBlock& block) {
  if (!solver_.corrector(block).field().knows_senses()) return std::nullopt;
  if (last_ == nullptr || block.kind != BlockKind::feed || !block.from_known) return std::nullopt;
  const Commanded& before = last_->commanded;
  const auto turned = [](int was, int is) { return was != 0 && is != 0 && was != is; };
  bool round = turned(before.tilt_sense, block.tilt_sense) || turned(before.turn_sense, block.turn_sense);
  for (std::size_t k = 0; k < 3; ++k) round |= turned(before.linear_sense[k], block.linear_sense[k]);
  if (!round) return std::nullopt;
  // Against the same moment with the senses of before: what drifts meanwhile is no leap.
  MotionBlock on = block;
  on.tilt_sense = static_cast<std::int8_t>(before.tilt_sense);
  on.turn_sense = static_cast<std::int8_t>(before.turn_sense);
  on.linear_sense = before.linear_sense;
  Solution begin = solver_.solved(block, block.from);
  const Solution was = solver_.solved(on, block.from);
  if (!solver_.leaps(was, begin)) return std::nullopt;
  if (!block.stops && !block.cutter && !(block.extras && !block.extras->undividable.empty())) return begin;
  leave(block, begin, was);
  return std::nullopt;
}

/// The senses of a block are those at its end: where a slide turns round on the way, the correction before that place
/// is off by all that the slide loses.
void ChunkWriter::note_turns_inside(const MotionBlock& block, const Solution& end) {
  if (block.turns_round == 0 || block.kind != BlockKind::feed || !solver_.corrector(block).field().knows_senses())
    return;
  MotionBlock before = block;
  for (std::size_t i = 0; i < 3; ++i)
    if (holds(block.turns_round, i)) before.linear_sense[i] = static_cast<std::int8_t>(-block.linear_sense[i]);
  if (const Solution was = solver_.solved(before, block.target); solver_.leaps(was, end)) leave(block, end, was);
}

void ChunkWriter::leave(const MotionBlock& block, const Solution& with, const Solution& without) {
  CorrectionCounts& counts = block_text_.out().counts;
  ++counts.reversals_left;
  const double size_mm = (with.linear.change_mm - without.linear.change_mm).norm();
  if (!(size_mm > counts.largest_reversal_left_mm)) return;
  counts.largest_reversal_left_mm = size_mm;
  counts.largest_reversal_left_line = block.line;
}

void ChunkWriter::correct(const MotionBlock& block) {
  Solution& end = last_ == &kept_[0] ? kept_[1] : kept_[0];
  solver_.solve(block, block.target, end);
  solver_.check(block.target, end);
  if (block.kind == BlockKind::feed && block.from_known && last_) solver_.check_change(*last_, end);
  const Ticks before = ticks_before(block);
  const std::optional<Solution> begin = taken_up(block);
  note_turns_inside(block, end);
  const bool whole = solver_.is_short(block) && !begin;
  if (whole && !new_feed(block, before, end.ticks, 1, 1).word &&
      block_text_.rewrite_plainly(block, end.ticks, before)) {
    lines_since_arc_ = false;
    count(end);
    last_ = &end;
  } else {
    correct(block, end, before, whole, begin);
  }
  ++block_text_.out().counts.corrected_blocks;
  ticks_ = end.ticks;
  ticks_unit_mm_ = block.unit_mm;
}

/// Any block but the usual one.
void ChunkWriter::correct(const MotionBlock& block, Solution& end, const Ticks& before, bool whole,
                          const std::optional<Solution>& begin) {
  Pen pen{.before = before, .last = before, .last_place = &block.from};
  NewFeed feed;
  std::vector<NewWords> pieces;
  bool within_tolerance = true;
  std::optional<Vector3d> centre;
  if (!whole && block.arc() != nullptr && !begin) centre = solver_.moved_arc(block, pen.before, end);
  if (whole || centre) {
    const NewWords words = this->words(block, end, true, pen);
    feed = new_feed(block, pen.before, end.ticks, 1, 1);
    if (!feed.word && !centre && !block.arc()) {
      block_text_.rewrite_numbers(block, words);
    } else {
      pieces.push_back(words);
    }
  } else {
    Way sent = solver_.is_short(block) ? Way{.ends = {end}} : solver_.way(block, end);
    pen.lines = block.arc() != nullptr || (block.straight_on_part && sent.ends.size() > 1);
    within_tolerance = sent.within_tolerance;
    if (begin) sent.ends.insert(sent.ends.begin(), *begin);
    for (const Solution& solution : sent.ends) {
      solver_.check(solution.programmed, solution);
      pieces.push_back(words(block, solution, &solution == &sent.ends.back(), pen));
      count(solution);
      remember(solution);
    }
    // A piece that only takes up costs no time of the others.
    feed =
        new_feed(block, begin ? begin->ticks : pen.before, end.ticks, pieces.size() - (begin ? 1 : 0), pieces.size());
  }
  if ((pieces.size() > 1 || feed.timed) && block.stops)
    throw RefusalError(
        pieces.size() > 1
            ? "a move that must be divided stands in one block with a program stop; give each its own block"
            : "a turn of the rotary axes stands in one block with a program stop; give each its own block");
  if (pieces.size() > 1 && block.extras && !block.extras->undividable.empty())
    throw RefusalError(std::string(block.extras->undividable) + " would have to be divided; post shorter moves");
  if (block.cutter && (pieces.size() > 1 || (block.arc() != nullptr && !centre)))
    throw RefusalError(
        "cutter radius compensation is active and this move would have to be divided; post the tool's centre path");
  if (block.arc() != nullptr) {
    feed.arc_code = !centre ? '1' : block.arc()->sweep_rad < 0 ? '2' : '3';
    feed.lines_for_arc = !centre;
    if (centre) feed.centre_mm = *centre;
    feed.begin = pen.before;
    // A block that says its code leaves the modal one as it was meant.
    if (centre && (block.motion_word.stands() || !lines_since_arc_)) feed.arc_code = 0;
  }
  lines_since_arc_ = block.arc() != nullptr && !centre;
  if (!pieces.empty()) {
    block_text_.rewrite(block, pieces.front(), feed);
    if (pieces.size() > 1 || feed.timed) {
      block_text_.end_line(block);
      for (std::size_t i = 1; i < pieces.size(); ++i) block_text_.insert(block, pieces[i], feed);
      if (feed.timed) block_text_.restore_feed(block);
      if (begin) block_text_.out().inserted.back().takes_up = true;
    }
  }
  CorrectionCounts& counts = block_text_.out().counts;
  if (!within_tolerance) ++counts.beyond_tolerance;
  if (pieces.size() > 1) {
    if (text_.feed_over_all_axes && !block.tcp && !block.straight_on_part)
      counts.assumptions |= only(Assumption::feed_over_all_axes);
    if (text_.function_in_every_block) counts.assumptions |= only(Assumption::shared_block_numbers);
  }
  if (feed.timed && text_.time_in_seconds) counts.assumptions |= only(Assumption::time_of_one_block);
  if (whole || centre) {
    count(end);
    last_ = &end;
  }
}

void ChunkWriter::count(const Solution& solution) {
  CorrectionCounts& counts = block_text_.out().counts;
  counts.largest_deviation_mm = std::max(counts.largest_deviation_mm, solution.linear.deviation_mm);
  raise_to(counts.largest_tilt_rad, solution.linear.error.rotation_rad);
  counts.largest_residual_rad = std::max(counts.largest_residual_rad, solution.residual.in_radians());
  counts.largest_c_correction_rad = std::max(counts.largest_c_correction_rad, std::abs(solution.turn_by.in_radians()));
  if (last_) {
    raise_to(counts.largest_position_change_mm, solution.linear.change_mm - last_->linear.change_mm);
    for (const Angle change : {solution.tilt_by - last_->tilt_by, solution.turn_by - last_->turn_by})
      counts.largest_rotary_change_rad = std::max(counts.largest_rotary_change_rad, std::abs(change.in_radians()));
  }
}

void ChunkWriter::set_position(const MotionBlock& block) {
  const Ticks now = ticks_before(block);
  NewWords words;
  for (std::size_t i = 0; i < kAxes; ++i)
    if (holds(block.programmed, i)) words[i] = block.word[i].value + now[i];
  block_text_.rewrite_numbers(block, words);
}

}  // namespace trunnion
