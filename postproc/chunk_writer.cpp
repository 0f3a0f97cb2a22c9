#include "postproc/chunk_writer.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "error.h"

namespace trunnion {
namespace {

using Eigen::Vector3d;

constexpr double kAbsurd_mm = 1000;  // no limit of a machine file lets this through
constexpr double kAngleRounding_deg = 1e-9;
constexpr double kStrokeRounding_mm = 1e-9;
constexpr double kSameDuration = 0.02;  // of a block's time: what a correction of microns may change
/// Moves shorter than both need no look at their middle: the correction bends by its second difference, and 2 deg of a
/// 30 um error scale bend 0.003 um.
constexpr double kStraight_deg = 2;
constexpr double kStraight_mm = 20;

std::string text_of(double value, int decimals) {
  std::string text;
  append_number(text, rounded(value, decimals), {});
  return text;
}

bool same(Decimal a, Decimal b) { return (a - b).mantissa == 0; }

AxisValues between(const AxisValues& from, const AxisValues& to, double s) {
  AxisValues at;
  for (std::size_t i = 0; i < kAxes; ++i) at[i] = s >= 1 ? to[i] : from[i] + s * (to[i] - from[i]);
  return at;
}

/// `at` with the axes of an arc's plane where they are after the part `s` of the way.
AxisValues with_arc(const MotionBlock& block, AxisValues at, double s) {
  if (!block.arc || s >= 1) return at;
  const Arc& arc = *block.arc;
  const double a = block.from[arc.first] - arc.centre_first, b = block.from[arc.second] - arc.centre_second;
  const double begin = std::hypot(a, b);
  const double end =
      std::hypot(block.target[arc.first] - arc.centre_first, block.target[arc.second] - arc.centre_second);
  const double grown = 1 + s * (end / begin - 1);
  const double cosine = std::cos(s * arc.sweep_rad), sine = std::sin(s * arc.sweep_rad);
  at[arc.first] = arc.centre_first + grown * (cosine * a - sine * b);
  at[arc.second] = arc.centre_second + grown * (sine * a + cosine * b);
  return at;
}

/// Where the programmed path is after the part `s` of its way.
AxisValues on_way(const MotionBlock& block, double s) {
  return with_arc(block, between(block.from, block.target, s), s);
}

Commanded between(const Commanded& from, const Commanded& to, double s) {
  Commanded at = to;
  at.xyz_mm = from.xyz_mm + s * (to.xyz_mm - from.xyz_mm);
  at.rotary.a = from.rotary.a + s * (to.rotary.a - from.rotary.a);
  at.rotary.c = from.rotary.c + s * (to.rotary.c - from.rotary.c);
  return at;
}

double length_mm(const AxisValues& from, const AxisValues& to) {
  return std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
}
double turn_deg(const AxisValues& from, const AxisValues& to) {
  return std::hypot(to[kTilt] - from[kTilt], to[kTurn] - from[kTurn]);
}

Commanded commanded(const MotionBlock& block, const AxisValues& at) {
  return {Vector3d(at[0], at[1], at[2]),
          {Angle::degrees(at[kTilt]), Angle::degrees(at[kTurn])},
          block.tilt_sense,
          block.turn_sense};
}

double unit(const MotionBlock& block, std::size_t axis) { return axis < 3 ? block.unit_mm : 1; }

/// `at` with the rotary axes where their words can say them: the position is then solved for the angles that are
/// written.
AxisValues on_grid(const MotionBlock& block, AxisValues at) {
  for (const std::size_t i : {kTilt, kTurn})
    at[i] = block.zero[i] + rounded(at[i] - block.zero[i], block.decimals[i]).value();
  return at;
}

/// Chords that keep within `tolerance_mm` of an arc, which leaves a tenth of it for the correction's own bend.
int chords(const MotionBlock& block, double tolerance_mm) {
  const Arc& arc = *block.arc;
  const double radius =
      std::hypot(block.from[arc.first] - arc.centre_first, block.from[arc.second] - arc.centre_second);
  const double step = 2 * std::acos(std::max(0.0, 1 - 0.9 * tolerance_mm / radius));
  return std::max(1, static_cast<int>(std::min(1e6, std::ceil(std::abs(arc.sweep_rad) / step))));
}

/// Enough decimals for seven digits of a feed.
Decimal feed_decimal(double value) {
  value = std::clamp(value, 1e-6, 1e9);
  const int whole = static_cast<int>(std::floor(std::log10(value))) + 1;
  return rounded(value, std::clamp(7 - whole, 0, kMostDecimals));
}

}  // namespace

CorrectionCounts& CorrectionCounts::operator+=(const CorrectionCounts& other) {
  lines += other.lines;
  corrected_blocks += other.corrected_blocks;
  copied_moves += other.copied_moves;
  changed_words += other.changed_words;
  added_words += other.added_words;
  inserted_blocks += other.inserted_blocks;
  beyond_tolerance += other.beyond_tolerance;
  largest_deviation_mm = std::max(largest_deviation_mm, other.largest_deviation_mm);
  largest_tilt_rad = std::max(largest_tilt_rad, other.largest_tilt_rad);
  largest_residual_rad = std::max(largest_residual_rad, other.largest_residual_rad);
  largest_position_change_mm = std::max(largest_position_change_mm, other.largest_position_change_mm);
  largest_rotary_change_rad = std::max(largest_rotary_change_rad, other.largest_rotary_change_rad);
  largest_c_correction_rad = std::max(largest_c_correction_rad, other.largest_c_correction_rad);
  return *this;
}

CorrectionGuard guard_of(const Machine& machine) {
  CorrectionGuard guard;
  guard.limits = machine.limits;
  const std::array<char, kAxes> letters = {'X', 'Y', 'Z', machine.tilt_letter(), 'C'};
  for (std::size_t i = 0; i < kAxes; ++i) {
    const Axis& axis = machine.axes.at(letters[i]);
    if (axis.range_length)
      guard.stroke[i] = {axis.range_length->low.in_millimetres(), axis.range_length->high.in_millimetres()};
    if (axis.range_angle && !axis.modulo)
      guard.stroke[i] = {axis.range_angle->low.in_degrees(), axis.range_angle->high.in_degrees()};
  }
  return guard;
}

CorrectedChunk ChunkWriter::write(std::string_view text, const ScannedChunk& scanned) {
  source_ = text;
  copied_ = 0;
  out_ = {};
  out_.text.reserve(text.size() + text.size() / 4);
  out_.counts.lines = scanned.lines;
  out_.counts.copied_moves = scanned.copied_moves;
  out_.refusals = scanned.refusals;
  if (!keep_going_) {
    last_.reset();
    ticks_ = {};
    lines_since_arc_ = false;
    if (const auto& before = scanned.before) {
      last_ = solve(*before, before->target);
      ticks_ = last_->ticks;
      ticks_unit_mm_ = before->unit_mm;
      lines_since_arc_ = before->arc && !stays_an_arc(*before, solve(*before, before->from), *last_);
    }
  }
  for (const MotionBlock& block : scanned.blocks) {
    try {
      block.kind == BlockKind::set_position ? set_position(block) : correct(block);
      continue;
    } catch (const RangeError& error) {
      out_.refusals.push_back({block.line, error.what(), Refusal::Kind::out_of_range});
    } catch (const RefusalError& error) {
      out_.refusals.push_back({block.line, error.what(), Refusal::Kind::refused});
    }
    if (!keep_going_) break;
    for (std::size_t i = 0; i < kAxes; ++i)
      if (holds(block.programmed, i) && !block.incremental) ticks_[i] = {};
    last_.reset();
  }
  std::ranges::stable_sort(out_.refusals, {}, &Refusal::line);
  copy_to(static_cast<std::uint32_t>(source_.size()));
  return std::move(out_);
}

// --- solving
// ----------------------------------------------------------------------------------------------------------

ChunkWriter::Solution ChunkWriter::solve(const MotionBlock& block, const AxisValues& at) const {
  const Commanded programmed = commanded(block, at);
  const Range<Angle> measured = corrector(block).tilt_range();
  if (at[kTilt] < measured.low.in_degrees() - kAngleRounding_deg ||
      at[kTilt] > measured.high.in_degrees() + kAngleRounding_deg)
    throw RangeError(std::string(1, letters_[kTilt]) + text_of(at[kTilt], 4) + ": outside the probed range " +
                     text_of(measured.low.in_degrees(), 4) + " ... " + text_of(measured.high.in_degrees(), 4) + " deg");
  const RotaryCorrection turn = corrector(block).rotary(programmed);
  if (!std::isfinite(turn.da.in_radians()) || !std::isfinite(turn.dc.in_radians()) ||
      std::abs(turn.da.in_radians()) > 1 || std::abs(turn.dc.in_radians()) > 1)
    throw RangeError("the model gives no usable correction of the rotary axes here");

  Solution solution;
  solution.programmed = at;
  solution.residual = turn.residual;
  solution.commanded = programmed;
  solution.ticks[kTilt] = rounded(turn.da.in_degrees(), block.decimals[kTilt]);
  solution.ticks[kTurn] = rounded(turn.dc.in_degrees(), block.decimals[kTurn]);
  // Angles as they will be written; the position follows them.
  if (solution.ticks[kTilt].mantissa != 0)
    solution.commanded.rotary.a = Angle::degrees(at[kTilt] + solution.ticks[kTilt].value());
  if (solution.ticks[kTurn].mantissa != 0)
    solution.commanded.rotary.c = Angle::degrees(at[kTurn] + solution.ticks[kTurn].value());
  solution.linear = corrector(block).linear(programmed, solution.commanded.rotary);
  if (!(solution.linear.change_mm.cwiseAbs().maxCoeff() < kAbsurd_mm) || !(solution.linear.deviation_mm < kAbsurd_mm))
    throw RangeError("the model gives no usable correction of the position here");
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Index axis = static_cast<Eigen::Index>(i);
    solution.ticks[i] = rounded(solution.linear.change_mm[axis] / block.unit_mm, block.decimals[i]);
    solution.commanded.xyz_mm[axis] += solution.ticks[i].value() * block.unit_mm;
  }
  return solution;
}

void ChunkWriter::check(const AxisValues& at, const Solution& solution) const {
  const double deviation = solution.linear.deviation_mm, tilt = solution.linear.error.rotation_rad.norm();
  if (deviation > guard_.limits.deviation.in_millimetres())
    throw RangeError("deviation " + text_of(deviation * 1e3, 1) + " um, limits.correction_um is " +
                     text_of(guard_.limits.deviation.in_micrometres(), 3));
  if (tilt > guard_.limits.tilt.in_radians())
    throw RangeError("tilt " + text_of(tilt * 1e6, 1) + " urad, limits.correction_urad is " +
                     text_of(guard_.limits.tilt.in_microradians(), 3));
  const Vector3d& slides = solution.linear.tip_r_mm;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (!guard_.stroke[i]) continue;
    // A rotary axis is judged by the programmed angle, a slide by where it would be sent.
    const double place = i < 3 ? slides[static_cast<Eigen::Index>(i)] : at[i];
    const double rounding = i < 3 ? kStrokeRounding_mm : kAngleRounding_deg;
    if (place < guard_.stroke[i]->first - rounding || place > guard_.stroke[i]->second + rounding)
      throw RangeError(std::string(1, letters_[i]) + " would go to " + text_of(place, 4) + (i < 3 ? " mm" : " deg") +
                       ", its stroke is " + text_of(guard_.stroke[i]->first, 4) + " ... " +
                       text_of(guard_.stroke[i]->second, 4));
  }
}

bool ChunkWriter::holds_between(const MotionBlock& block, const Solution& from, double from_part, const Solution& to,
                                double to_part, double& tip_mm, double& tilt_rad) const {
  const Corrector& judge = corrector(block);
  for (const double s : {0.5, 0.25, 0.75}) {
    const double part = from_part + s * (to_part - from_part);
    const Commanded wanted = commanded(block, with_arc(block, between(from.programmed, to.programmed, s), part));
    const Commanded sent = between(from.commanded, to.commanded, s);
    tip_mm = std::max(tip_mm, judge.tip_error_mm(wanted, sent));
    // What damping leaves there is not the line's fault.
    if (judge.settings().orientation == Orientation::corrected)
      tilt_rad =
          std::max(tilt_rad, (judge.tilt_error(wanted, sent.rotary) - judge.rotary(wanted).residual).in_radians());
  }
  return tip_mm <= guard_.tolerance_mm && tilt_rad <= guard_.tolerance_rad;
}

bool ChunkWriter::stays_an_arc(const MotionBlock& block, const Solution& begin, const Solution& end) const {
  if (!block.arc_movable)
    return std::ranges::all_of(end.ticks, [](Decimal t) { return t.mantissa == 0; }) && bends_less(block, begin, end);
  return bends_less(block, begin, end);
}

bool ChunkWriter::bends_less(const MotionBlock& block, const Solution& begin, const Solution& end) const {
  for (std::size_t i = 0; i < kAxes; ++i)
    if (!same(begin.ticks[i], end.ticks[i])) return false;
  constexpr int kLooks = 16;  // the errors' harmonics are far coarser
  for (int k = 1; k < kLooks; ++k) {
    const Commanded wanted = commanded(block, on_way(block, static_cast<double>(k) / kLooks));
    Commanded sent = wanted;
    sent.xyz_mm += end.commanded.xyz_mm - commanded(block, block.target).xyz_mm;
    sent.rotary.a = sent.rotary.a + Angle::degrees(end.ticks[kTilt].value());
    sent.rotary.c = sent.rotary.c + Angle::degrees(end.ticks[kTurn].value());
    if (corrector(block).tip_error_mm(wanted, sent) > guard_.tolerance_mm) return false;
    if (corrector(block).settings().orientation == Orientation::corrected &&
        (corrector(block).tilt_error(wanted, sent.rotary) - corrector(block).rotary(wanted).residual).in_radians() >
            guard_.tolerance_rad)
      return false;
  }
  return true;
}

ChunkWriter::Way ChunkWriter::way(const MotionBlock& block, const Solution& end) const {
  if (block.kind != BlockKind::feed || !block.from_known || !last_) return {{end}};
  if (!block.arc && turn_deg(block.from, block.target) <= kStraight_deg &&
      length_mm(block.from, block.target) <= kStraight_mm)
    return {{end}};
  const Solution begin = solve(block, block.from);
  if (block.arc && stays_an_arc(block, begin, end)) return {.ends = {end}, .arc = true};
  const int most = block.arc ? guard_.most_arc_pieces : guard_.most_pieces;
  for (int n = block.arc ? std::min(most, chords(block, guard_.tolerance_mm)) : 1;;) {
    Way way;
    double tip_mm = 0, tilt_rad = 0;
    way.ends.reserve(static_cast<std::size_t>(n));
    for (int k = 1; k <= n; ++k) {
      const double before = static_cast<double>(k - 1) / n, after = static_cast<double>(k) / n;
      way.ends.push_back(k == n ? end : solve(block, on_grid(block, on_way(block, after))));
      const Solution& from = k == 1 ? begin : way.ends[static_cast<std::size_t>(k) - 2];
      if (!holds_between(block, from, before, way.ends.back(), after, tip_mm, tilt_rad)) way.within_tolerance = false;
    }
    if (way.within_tolerance || n >= most) return way;
    // A chord's error falls with the square of its length.
    const double excess = std::max(tip_mm / guard_.tolerance_mm, tilt_rad / guard_.tolerance_rad);
    n = std::min(most, std::max(n + 1, static_cast<int>(std::ceil(n * std::sqrt(std::min(excess, 1e6))))));
  }
}

// --- what to write
// ----------------------------------------------------------------------------------------------------

ChunkWriter::Ticks ChunkWriter::ticks_before(const MotionBlock& block) const {
  Ticks ticks = ticks_;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (holds(block.raw_since, i)) ticks[i] = {};
    if (i < 3 && ticks_unit_mm_ != block.unit_mm && ticks[i].mantissa != 0)
      ticks[i] = rounded(ticks[i].value() * ticks_unit_mm_ / block.unit_mm, block.decimals[i]);
  }
  return ticks;
}

std::vector<ChunkWriter::Piece> ChunkWriter::pieces(const MotionBlock& block, const std::vector<Solution>& way,
                                                    const Ticks& before) const {
  const AxisValues* last_place = &block.from;
  std::vector<Piece> pieces;
  pieces.reserve(way.size());
  std::array<Decimal, kAxes> moved{};  // what incremental words have said so far
  const Ticks* last_ticks = &before;
  for (const Solution& end : way) {
    Piece piece{end, {}};
    const bool final = &end == &way.back();
    for (std::size_t i = 0; i < kAxes; ++i) {
      const bool programmed = holds(block.programmed, i);
      const bool moves = block.arc && end.programmed[i] != (*last_place)[i];
      if (!programmed && !moves && same(end.ticks[i], (*last_ticks)[i])) continue;
      // Inside the block no digits are given: the place as it is solved, rounded once.
      const double change =
          i < 3 ? end.linear.change_mm[static_cast<Eigen::Index>(i)] / block.unit_mm : end.ticks[i].value();
      const double from = block.incremental ? block.from[i] : block.zero[i];
      const double place = (end.programmed[i] - from) / unit(block, i) + change;
      if (!block.incremental) {
        piece.words[i] = programmed && final ? block.word[i].number + end.ticks[i] : rounded(place, block.decimals[i]);
      } else {
        const Decimal whole = final ? (programmed ? block.word[i].number : Decimal{}) + end.ticks[i] - before[i]
                                    : rounded(place - before[i].value(), block.decimals[i]);
        piece.words[i] = whole - moved[i];
        moved[i] = whole;
      }
    }
    last_ticks = &end.ticks;
    last_place = &end.programmed;
    pieces.push_back(piece);
  }
  return pieces;
}

ChunkWriter::NewFeed ChunkWriter::new_feed(const MotionBlock& block, const Ticks& before, const Ticks& after,
                                           std::size_t pieces) const {
  if (block.kind != BlockKind::feed) return {};
  const double n = static_cast<double>(pieces);
  if (block.feed_mode == FeedMode::inverse_time) {
    if (pieces == 1) return {};
    if (block.feed <= 0) throw RefusalError("F is not known: with G93 every block that moves needs its own");
    return {feed_decimal(block.feed * n), false};
  }
  const double turn = turn_deg(block.from, block.target);
  if (!block.from_known || block.arc || turn == 0) return {};
  AxisValues to = block.target;
  bool changed = false;
  for (std::size_t i = 0; i < 3; ++i) {
    const Decimal step = after[i] - before[i];
    changed |= step.mantissa != 0;
    to[i] += step.value() * block.unit_mm;
  }
  if (!changed) return {};
  // F runs along X Y Z where any of them moves, else along the rotary axes in degrees.
  const double nominal = length_mm(block.from, block.target), corrected = length_mm(block.from, to);
  if (nominal > 0 && std::abs(corrected / nominal - 1) < kSameDuration) return {};
  if (block.feed_mode == FeedMode::per_revolution)
    throw RefusalError("a turn of the rotary axes in G95 whose X Y Z correction would change its duration");
  if (block.feed <= 0) throw RefusalError("F is not known, so the duration of this turn cannot be kept");
  const double minutes = nominal > 0 ? nominal / (block.feed * block.feed_unit_mm) : turn / block.feed;
  return {feed_decimal(n / minutes), true};
}

void ChunkWriter::correct(const MotionBlock& block) {
  const Solution end = solve(block, block.target);
  check(block.target, end);
  const Ticks before = ticks_before(block);
  const Way sent = way(block, end);
  const std::vector<Solution>& ends = sent.ends;
  for (const Solution& solution : ends) check(solution.programmed, solution);
  if (ends.size() > 1 && block.stops)
    throw RefusalError("a move that must be divided stands in one block with a program stop; give each its own block");
  const std::vector<Piece> parts = pieces(block, ends, before);
  NewFeed feed = new_feed(block, before, end.ticks, parts.size());
  if (feed.inverse_time_meanwhile && block.stops)
    throw RefusalError("a turn of the rotary axes stands in one block with a program stop; give each its own block");
  if (block.arc) {
    feed.arc_code = !sent.arc ? 1 : block.arc->sweep_rad < 0 ? 2 : 3;
    feed.lines_for_arc = !sent.arc;
    // A block that says its code leaves the modal one as it was meant.
    if (sent.arc && (block.motion_word || !lines_since_arc_)) feed.arc_code = 0;
  }
  lines_since_arc_ = block.arc && !sent.arc;

  rewrite(block, parts.front().words, feed);
  if (parts.size() > 1 || feed.inverse_time_meanwhile) {
    end_line(block);
    for (std::size_t i = 1; i < parts.size(); ++i) insert(block, parts[i].words, feed);
    if (feed.inverse_time_meanwhile) restore_feed(block);
  }
  ++out_.counts.corrected_blocks;
  if (!sent.within_tolerance) ++out_.counts.beyond_tolerance;
  for (const Solution& solution : ends) {
    count(solution);
    last_ = solution;
  }
  ticks_ = end.ticks;
  ticks_unit_mm_ = block.unit_mm;
}

void ChunkWriter::count(const Solution& solution) {
  CorrectionCounts& counts = out_.counts;
  const auto by = [](const Solution& s) {
    return std::array<double, 2>{Angle::degrees(s.ticks[kTilt].value()).in_radians(),
                                 Angle::degrees(s.ticks[kTurn].value()).in_radians()};
  };
  counts.largest_deviation_mm = std::max(counts.largest_deviation_mm, solution.linear.deviation_mm);
  counts.largest_tilt_rad = std::max(counts.largest_tilt_rad, solution.linear.error.rotation_rad.norm());
  counts.largest_residual_rad = std::max(counts.largest_residual_rad, solution.residual.in_radians());
  counts.largest_c_correction_rad = std::max(counts.largest_c_correction_rad, std::abs(by(solution)[1]));
  if (last_) {
    counts.largest_position_change_mm =
        std::max(counts.largest_position_change_mm, (solution.linear.change_mm - last_->linear.change_mm).norm());
    for (std::size_t i = 0; i < 2; ++i)
      counts.largest_rotary_change_rad =
          std::max(counts.largest_rotary_change_rad, std::abs(by(solution)[i] - by(*last_)[i]));
  }
}

void ChunkWriter::set_position(const MotionBlock& block) {
  const Ticks now = ticks_before(block);
  NewWords words;
  for (std::size_t i = 0; i < kAxes; ++i)
    if (holds(block.programmed, i)) words[i] = block.word[i].number + now[i];
  rewrite(block, words, {});
}

// --- writing
// ----------------------------------------------------------------------------------------------------------

void ChunkWriter::copy_to(std::uint32_t place) {
  out_.text.append(source_.substr(copied_, place - copied_));
  copied_ = place;
}

void ChunkWriter::append_word(const MotionBlock& block, std::size_t axis, Decimal value, bool blank) {
  if (blank) out_.text += ' ';
  const bool small = block.words > 0 && source_[block.word[block.order[0]].text] >= 'a';
  out_.text += static_cast<char>(small ? letters_[axis] - 'A' + 'a' : letters_[axis]);
  append_number(out_.text, value, block.style[axis]);
  ++out_.counts.added_words;
}

void ChunkWriter::append_feed(const MotionBlock& block, Decimal value, bool blank) {
  if (blank && block.blank_before_words) out_.text += ' ';
  out_.text += 'F';
  append_number(out_.text, value, block.feed_word ? block.feed_word->style : NumberStyle{});
}

void ChunkWriter::rewrite(const MotionBlock& block, const NewWords& words, const NewFeed& feed) {
  struct Edit {
    const WordPlace* word;
    std::optional<Decimal> value;  // none: the word goes
  };
  std::array<Edit, kAxes + 8> edits{};
  std::size_t count = 0;
  std::uint32_t first_word = block.end, last_word = block.begin;
  const auto anchor = [&](const WordPlace& word) {
    first_word = std::min(first_word, word.text);
    last_word = std::max(last_word, word.end);
  };
  for (std::size_t i = 0; i < block.words; ++i) {
    const std::size_t axis = block.order[i];
    anchor(block.word[axis]);
    if (words[axis] && !same(*words[axis], block.word[axis].number)) {
      edits[count++] = {&block.word[axis], words[axis]};
      ++out_.counts.changed_words;
    }
  }
  for (std::size_t i = 0; i < block.arc_words; ++i) {
    anchor(block.arc_word[i]);
    if (feed.lines_for_arc) {
      edits[count++] = {&block.arc_word[i], std::nullopt};
      ++out_.counts.changed_words;
    }
  }
  if (feed.word && block.feed_word) edits[count++] = {&*block.feed_word, feed.word};
  if (feed.inverse_time_meanwhile && block.feed_mode_word) edits[count++] = {&*block.feed_mode_word, Decimal{93, 0}};
  if (feed.arc_code != 0 && block.motion_word) edits[count++] = {&*block.motion_word, Decimal{feed.arc_code, 0}};

  // Words to be added stand behind the last word of the move, codes before the first.
  const bool add_mode = feed.inverse_time_meanwhile && !block.feed_mode_word;
  const bool add_code = feed.arc_code != 0 && !block.motion_word;
  bool add = feed.word && !block.feed_word;
  for (std::size_t i = 0; i < kAxes; ++i) add |= words[i] && !holds(block.programmed, i);
  std::sort(edits.begin(), edits.begin() + static_cast<std::ptrdiff_t>(count),
            [](const Edit& a, const Edit& b) { return a.word->text < b.word->text; });

  std::size_t next = 0;
  const auto edit_before = [&](std::uint32_t place) {
    for (; next < count && edits[next].word->text < place; ++next) {
      const WordPlace& word = *edits[next].word;
      if (edits[next].value) {
        std::uint32_t number = word.text + 1;
        while (source_[number] == ' ' || source_[number] == '\t') ++number;
        copy_to(number);
        append_number(out_.text, *edits[next].value, word.style);
      } else {
        copy_to(word.text);
        while (out_.text.ends_with(' ') || out_.text.ends_with('\t')) out_.text.pop_back();
      }
      copied_ = word.end;
    }
  };
  if (add_mode || add_code) {
    edit_before(first_word);
    copy_to(first_word);
    const std::string_view apart = block.blank_before_words ? " " : "";
    if (add_mode) out_.text.append("G93").append(apart);
    if (add_code) out_.text.append("G").append(std::to_string(feed.arc_code)).append(apart);
    out_.counts.added_words += add_code;
  }
  if (add) {
    edit_before(last_word);
    copy_to(last_word);
    for (std::size_t i = 0; i < kAxes; ++i)
      if (words[i] && !holds(block.programmed, i)) append_word(block, i, *words[i], block.blank_before_words);
    if (feed.word && !block.feed_word) append_feed(block, *feed.word, true);
  }
  edit_before(block.end);
}

void ChunkWriter::end_line(const MotionBlock& block) {
  copy_to(block.end);
  if (line_end(source_.substr(block.begin, block.end - block.begin)).empty()) out_.text += '\n';
}

void ChunkWriter::insert(const MotionBlock& block, const NewWords& words, const NewFeed& feed) {
  bool blank = false;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (!words[i]) continue;
    append_word(block, i, *words[i], blank);
    blank = block.blank_before_words;
  }
  out_.counts.added_words -=
      static_cast<std::uint64_t>(std::ranges::count_if(words, [](const auto& w) { return w.has_value(); }));
  if (feed.word) append_feed(block, *feed.word, true);
  insert_line_end(block);
}

void ChunkWriter::restore_feed(const MotionBlock& block) {
  // F counts in the units of the block that says it, as mm for X Y Z and as degrees for the rotary axes.
  const bool other_unit = block.feed_unit_mm != block.unit_mm;
  if (other_unit) {
    out_.text += block.feed_unit_mm == 1 ? "G21" : "G20";
    insert_line_end(block);
  }
  out_.text += "G94";
  append_feed(block, feed_decimal(block.feed), true);
  insert_line_end(block);
  if (other_unit) {
    out_.text += block.unit_mm == 1 ? "G21" : "G20";
    insert_line_end(block);
  }
}

void ChunkWriter::insert_line_end(const MotionBlock& block) {
  const std::string_view end = line_end(source_.substr(block.begin, block.end - block.begin));
  out_.text += end.empty() ? "\n" : end;
  ++out_.counts.inserted_blocks;
  if (out_.inserted.empty() || out_.inserted.back().line != block.line) out_.inserted.push_back({block.line, 0});
  ++out_.inserted.back().count;
}

}  // namespace trunnion
