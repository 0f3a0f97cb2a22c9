#include "postproc/chunk_writer.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "error.h"
#include "postproc/block.h"
#include "postproc/tool_axis.h"

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
constexpr double kShortestTime_s = 0.001, kLongestTime_s = 999.999;  // of FT
constexpr int kTimeDecimals = 4;

constexpr int kDirectionDecimals = 7;  // a tenth of a microradian

std::string text_of(double value, int decimals) {
  std::string text;
  append_number(text, rounded(value, decimals), {});
  return text;
}

bool same(Decimal a, Decimal b) { return a.decimals == b.decimals ? a.mantissa == b.mantissa : (a - b).mantissa == 0; }

AxisValues between(const AxisValues& from, const AxisValues& to, double s) {
  AxisValues at;
  for (std::size_t i = 0; i < kAxes; ++i) at[i] = s >= 1 ? to[i] : from[i] + s * (to[i] - from[i]);
  return at;
}

/// `at` with X Y Z where an arc is after the part `s` of its way.
AxisValues with_arc(const Arc* arc, AxisValues at, double s) {
  if (arc == nullptr || s >= 1) return at;
  const double angle = s * arc->sweep_rad;
  const Vector3d place = arc->centre +
                         (1 + s * arc->growth) * (std::cos(angle) * arc->along + std::sin(angle) * arc->across) +
                         s * arc->rise;
  for (std::size_t i = 0; i < 3; ++i) at[i] = place[static_cast<Eigen::Index>(i)];
  return at;
}

double square(double x) { return x * x; }
double length_mm(const AxisValues& from, const AxisValues& to) {
  return std::sqrt(square(to[0] - from[0]) + square(to[1] - from[1]) + square(to[2] - from[2]));
}
double turn_deg(const AxisValues& from, const AxisValues& to) {
  return std::sqrt(square(to[kTilt] - from[kTilt]) + square(to[kTurn] - from[kTurn]));
}

double unit(const MotionBlock& block, std::size_t axis) { return axis < 3 ? block.unit_mm : 1; }

/// Of R or W, from one of the program's frame.
Vector3d out_of_frame(const MotionBlock& block, const Vector3d& v) {
  const ProgramFrame* frame = block.frame();
  return frame != nullptr ? Vector3d(frame->rotation * v) : v;
}
Vector3d into_frame(const MotionBlock& block, const Vector3d& v) {
  const ProgramFrame* frame = block.frame();
  return frame != nullptr ? Vector3d(frame->rotation.transpose() * v) : v;
}

bool by_vectors(const MotionBlock& block) { return block.extras && block.extras->direction_in_effect; }

/// `at` with the rotary axes where their words can say them: the position is then solved for the angles that are
/// written.
AxisValues on_grid(const MotionBlock& block, AxisValues at) {
  for (const std::size_t i : {kTilt, kTurn})
    at[i] = block.zero[i] + rounded(at[i] - block.zero[i], block.decimals[i]).value();
  return at;
}

/// Chords that keep within `tolerance_mm` of an arc, which leaves a tenth of it for the correction's own bend.
int chords(const Arc& arc, double tolerance_mm) {
  const double step = 2 * std::acos(std::max(0.0, 1 - 0.9 * tolerance_mm / arc.along.norm()));
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
  const auto limit = [&](const char* key, double otherwise) {
    const auto found = machine.profile.find(key);
    return found == machine.profile.end() ? otherwise : std::get<double>(found->second);
  };
  guard.change = Length::micrometres(limit("limits.change_um", guard.change.in_micrometres()));
  guard.rotary_change = Angle::degrees(limit("limits.change_deg", guard.rotary_change.in_degrees()));
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
  out_.text.reserve(text.size() + text.size() / 8);
  out_.counts.lines = scanned.lines;
  out_.counts.copied_moves = scanned.copied_moves;
  out_.refusals = scanned.refusals;
  if (!keep_going_) {
    last_.reset();
    ticks_ = {};
    lines_since_arc_ = false;
    if (const auto& before = scanned.before) {
      last_ = solved(*before, before->target);
      ticks_ = last_->ticks;
      ticks_unit_mm_ = before->unit_mm;
      lines_since_arc_ = before->arc() != nullptr && !moved_arc(*before, solved(*before, before->from).ticks, *last_);
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
      if (holds(block.programmed, i) && !holds(block.incremental, i)) ticks_[i] = {};
    last_.reset();
  }
  std::ranges::stable_sort(out_.refusals, {}, &Refusal::line);
  copy_to(static_cast<std::uint32_t>(source_.size()));
  return std::move(out_);
}

// --- solving
// ----------------------------------------------------------------------------------------------------------

Commanded ChunkWriter::commanded(const MotionBlock& block, const AxisValues& at) const {
  Commanded place{Vector3d(at[0], at[1], at[2]),
                  {Angle::degrees(at[kTilt]), Angle::degrees(at[kTurn])},
                  block.tilt_sense,
                  block.turn_sense};
  if (const ProgramFrame* frame = block.frame()) place.xyz_mm = frame->origin_mm + frame->rotation * place.xyz_mm;
  return place;
}

/// Where the programmed path is between two places of it.
AxisValues ChunkWriter::place_between(const MotionBlock& block, const AxisValues& from, const AxisValues& to,
                                      double s) const {
  AxisValues at = between(from, to, s);
  if (!block.straight_on_part || s >= 1) return at;
  const Vector3d xyz =
      sent_between(block, commanded(block, from), commanded(block, to), s).xyz_mm;  // such blocks have no frame
  for (std::size_t i = 0; i < 3; ++i) at[i] = xyz[static_cast<Eigen::Index>(i)];
  return at;
}

/// Where the programmed path is after the part `s` of its way.
AxisValues ChunkWriter::on_way(const MotionBlock& block, double s) const {
  return with_arc(block.arc(), place_between(block, block.from, block.target, s), s);
}

Commanded ChunkWriter::sent_between(const MotionBlock& block, const Commanded& from, const Commanded& to,
                                    double s) const {
  Commanded at = to;
  at.rotary.a = from.rotary.a + s * (to.rotary.a - from.rotary.a);
  at.rotary.c = from.rotary.c + s * (to.rotary.c - from.rotary.c);
  if (block.straight_on_part) {
    const KinematicChain& chain = corrector(block).chain();
    const auto on_part = [&](const Commanded& c) { return chain.r_from_w(c.rotary).inverse() * c.xyz_mm; };
    const Vector3d begin = on_part(from), end = on_part(to);
    at.xyz_mm = chain.r_from_w(at.rotary) * Vector3d(begin + s * (end - begin));
  } else {
    at.xyz_mm = from.xyz_mm + s * (to.xyz_mm - from.xyz_mm);
  }
  return at;
}

/// Whether the rotary axes of the block are corrected as well.
bool ChunkWriter::turns(const MotionBlock& block) const {
  return !block.rotary_fixed && with_tcp_.settings().orientation == Orientation::corrected;
}

void ChunkWriter::solve(const MotionBlock& block, const AxisValues& at, Solution& solution) const {
  const Corrector& solver = corrector(block);
  const Commanded programmed = commanded(block, at);
  const Range<Angle> measured = solver.tilt_range();
  if (at[kTilt] < measured.low.in_degrees() - kAngleRounding_deg ||
      at[kTilt] > measured.high.in_degrees() + kAngleRounding_deg)
    throw RangeError(std::string(1, letters_[kTilt]) + text_of(at[kTilt], 4) + ": outside the probed range " +
                     text_of(measured.low.in_degrees(), 4) + " ... " + text_of(measured.high.in_degrees(), 4) + " deg");
  const Corrector::Solved solved =
      solver.solve(programmed, block.decimals[kTilt], block.decimals[kTurn], !block.rotary_fixed);
  solution.programmed = at;
  solution.residual = solved.turn.residual;
  solution.commanded = programmed;
  solution.commanded.rotary = solved.rotary;
  solution.ticks[kTilt] = solved.tilt_deg;
  solution.ticks[kTurn] = solved.turn_deg;
  solution.tilt_by = solved.tilt_by;
  solution.turn_by = solved.turn_by;
  solution.linear = solved.linear;
  if (!(solution.linear.change_mm.cwiseAbs().maxCoeff() < kAbsurd_mm) || !(solution.linear.deviation_mm < kAbsurd_mm))
    throw RangeError("the model gives no usable correction of the position here");
  const Vector3d change = into_frame(block, solution.linear.change_mm);
  Vector3d step;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Index axis = static_cast<Eigen::Index>(i);
    solution.ticks[i] = rounded(change[axis] / block.unit_mm, block.decimals[i]);
    step[axis] = solution.ticks[i].value() * block.unit_mm;
  }
  solution.commanded.xyz_mm += out_of_frame(block, step);
}

ChunkWriter::Solution ChunkWriter::solved(const MotionBlock& block, const AxisValues& at) const {
  Solution solution;
  solve(block, at, solution);
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

/// The correction's jump from one block to the next: a model that leaps would leave a mark on the part.
void ChunkWriter::check_change(const Solution& before, const Solution& now) const {
  const double change = (now.linear.change_mm - before.linear.change_mm).norm();
  if (change > guard_.change.in_millimetres())
    throw RangeError("the correction changes by " + text_of(change * 1e3, 1) +
                     " um from the block before, limits.change_um is " + text_of(guard_.change.in_micrometres(), 3));
  for (const std::size_t i : {kTilt, kTurn}) {
    const Angle by = i == kTilt ? now.tilt_by - before.tilt_by : now.turn_by - before.turn_by;
    if (std::abs(by.in_radians()) <= guard_.rotary_change.in_radians()) continue;
    const double turn = std::abs((now.ticks[i] - before.ticks[i]).value());
    if (turn > guard_.rotary_change.in_degrees())
      throw RangeError(std::string("the correction of ") + letters_[i] + " changes by " + text_of(turn, 4) +
                       " deg from the block before, limits.change_deg is " +
                       text_of(guard_.rotary_change.in_degrees(), 4));
  }
}

/// What of the tool axis a block's own correction misses; not what damping leaves.
double ChunkWriter::tilt_left_rad(const MotionBlock& block, const Commanded& wanted, const Commanded& sent) const {
  // Where the rotary axes stand, their correction does.
  if (block.from_known && turn_deg(block.from, block.target) == 0) return 0;
  const Corrector& judge = corrector(block);
  return (judge.tilt_error(wanted, sent.rotary) - judge.rotary(wanted).residual).in_radians();
}

bool ChunkWriter::holds_between(const MotionBlock& block, const Solution& from, double from_part, const Solution& to,
                                double to_part, double& tip_mm, double& tilt_rad) const {
  for (const double s : {0.5, 0.25, 0.75}) {
    const double part = from_part + s * (to_part - from_part);
    const Commanded wanted =
        commanded(block, with_arc(block.arc(), place_between(block, from.programmed, to.programmed, s), part));
    const Commanded sent = sent_between(block, from.commanded, to.commanded, s);
    tip_mm = std::max(tip_mm, corrector(block).tip_error_mm(wanted, sent));
    if (turns(block)) tilt_rad = std::max(tilt_rad, tilt_left_rad(block, wanted, sent));
  }
  return tip_mm <= guard_.tolerance_mm && tilt_rad <= guard_.tolerance_rad;
}

/// By how much an arc is moved if it stays an arc within tolerance, in the program's frame: from where it begins
/// corrected to where it ends corrected, its centre midway. Arcs whose centre the block does not tell stay only
/// unmoved.
std::optional<Eigen::Vector3d> ChunkWriter::moved_arc(const MotionBlock& block, const Ticks& before,
                                                      const Solution& end) const {
  const Arc& meant = *block.arc();
  const bool unmoved = std::ranges::all_of(end.ticks, [](Decimal t) { return t.mantissa == 0; }) &&
                       std::ranges::all_of(before, [](Decimal t) { return t.mantissa == 0; });
  if (!block.extras->arc_movable && !unmoved) return std::nullopt;
  Vector3d at_begin, at_end, centre;
  bool by_centre = false, equal = true;
  for (const ArcWord& word : block.extras->arc_word)
    by_centre |= word.tells == ArcWord::Tells::centre || word.tells == ArcWord::Tells::centre_from_begin;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Index axis = static_cast<Eigen::Index>(i);
    at_begin[axis] = before[i].value() * block.unit_mm;
    at_end[axis] = end.ticks[i].value() * block.unit_mm;
    equal &= same(before[i], end.ticks[i]);
    centre[axis] = rounded(0.5 * (before[i].value() + end.ticks[i].value()), block.decimals[i]).value() * block.unit_mm;
  }
  if (!by_centre && !equal) return std::nullopt;
  // The third axis has no centre.
  const Vector3d normal = meant.along.cross(meant.across).normalized();
  Arc sent = meant;
  sent.centre += centre - normal * normal.dot(centre - at_begin);
  sent.along += at_begin - (sent.centre - meant.centre);
  sent.across = normal.cross(sent.along);
  sent.rise += normal * normal.dot(at_end - at_begin);
  const Vector3d to = Vector3d(block.target[0], block.target[1], block.target[2]) + at_end - sent.centre - sent.rise;
  sent.growth = to.norm() / sent.along.norm() - 1;
  // The same whole turns, and between them the angle to the moved end.
  const double bend =
      std::remainder(std::atan2(to.dot(sent.across), to.dot(sent.along)) - meant.sweep_rad, 2 * std::numbers::pi);
  sent.sweep_rad += bend;
  constexpr int kLooks = 16;  // the errors' harmonics are far coarser
  for (int k = 1; k < kLooks; ++k) {
    const double s = static_cast<double>(k) / kLooks;
    const Commanded wanted = commanded(block, on_way(block, s));
    AxisValues at = with_arc(&sent, between(block.from, block.target, s), s);
    for (const std::size_t i : {kTilt, kTurn})
      at[i] += before[i].value() + s * (end.ticks[i].value() - before[i].value());
    const Commanded there = commanded(block, at);
    if (corrector(block).tip_error_mm(wanted, there) > guard_.tolerance_mm) return std::nullopt;
    if (turns(block) && tilt_left_rad(block, wanted, there) > guard_.tolerance_rad) return std::nullopt;
  }
  return centre;
}

bool ChunkWriter::is_short(const MotionBlock& block) const {
  if (block.kind != BlockKind::feed || !block.from_known || !last_) return true;
  return block.arc() == nullptr && turn_deg(block.from, block.target) <= kStraight_deg &&
         length_mm(block.from, block.target) <= kStraight_mm;
}

ChunkWriter::Way ChunkWriter::way(const MotionBlock& block, const Solution& end) const {
  const Arc* arc = block.arc();
  const Solution begin = solved(block, block.from);
  const int most = arc != nullptr ? guard_.most_arc_pieces : guard_.most_pieces;
  for (int n = arc != nullptr ? std::min(most, chords(*arc, guard_.tolerance_mm)) : 1;;) {
    Way way;
    double tip_mm = 0, tilt_rad = 0;
    way.ends.reserve(static_cast<std::size_t>(n));
    for (int k = 1; k <= n; ++k) {
      const double before = static_cast<double>(k - 1) / n, after = static_cast<double>(k) / n;
      way.ends.push_back(k == n ? end : solved(block, on_grid(block, on_way(block, after))));
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

ChunkWriter::NewWords ChunkWriter::words(const MotionBlock& block, const Solution& end, bool final, Pen& pen) const {
  NewWords words;
  const bool vectors = by_vectors(block);
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (i >= kTilt && (vectors || block.rotary_fixed)) break;
    const bool programmed = holds(block.programmed, i);
    const bool moves = pen.lines && end.programmed[i] != (*pen.last_place)[i];
    if (!programmed && !moves && same(end.ticks[i], pen.last[i])) continue;
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
  const KinematicChain& chain = corrector(block).chain();
  const auto& programmed = block.extras->direction;
  const bool moves = programmed && !final;
  if (!programmed && same(end.ticks[kTilt], pen.last[kTilt]) && same(end.ticks[kTurn], pen.last[kTurn])) return;
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

ChunkWriter::NewFeed ChunkWriter::new_feed(const MotionBlock& block, const Ticks& before, const Ticks& after,
                                           std::size_t pieces) const {
  if (block.kind != BlockKind::feed) return {};
  const double n = static_cast<double>(pieces);
  if (block.feed_mode == FeedMode::inverse_time) {
    if (pieces == 1) return {};
    if (block.feed <= 0) throw RefusalError("F is not known: with G93 every block that moves needs its own");
    return {.word = feed_decimal(block.feed * n)};
  }
  const double turn = turn_deg(block.from, block.target);
  if (!block.from_known || block.arc() != nullptr || turn == 0) return {};
  if (text_.feed_over_all_axes && !block.tcp && !block.straight_on_part) return {};
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
  if (!text_.time_in_seconds) return {.word = feed_decimal(n / minutes), .timed = true};
  const double seconds = 60 * minutes / n;
  if (seconds > kLongestTime_s || seconds < kShortestTime_s)
    throw RefusalError("the duration of this turn, " + text_of(seconds, 4) + " s, is beyond what FT can say");
  return {.word = rounded(seconds, kTimeDecimals), .timed = true};
}

void ChunkWriter::correct(const MotionBlock& block) {
  Solution end;
  solve(block, block.target, end);
  check(block.target, end);
  if (block.kind == BlockKind::feed && block.from_known && last_) check_change(*last_, end);
  Pen pen{.before = ticks_before(block), .last_place = &block.from};
  pen.last = pen.before;
  NewFeed feed;
  std::vector<NewWords> pieces;
  bool within_tolerance = true;
  const bool whole = is_short(block);
  std::optional<Vector3> centre;
  if (!whole && block.arc() != nullptr) centre = moved_arc(block, pen.before, end);
  if (whole) feed = new_feed(block, pen.before, end.ticks, 1);
  if (whole && !feed.word && rewrite_plainly(block, end, pen.before)) {
    lines_since_arc_ = false;
  } else if (whole || centre) {
    const NewWords words = this->words(block, end, true, pen);
    feed = new_feed(block, pen.before, end.ticks, 1);
    if (!feed.word && !centre && !block.arc()) {
      rewrite_numbers(block, words);
    } else {
      pieces.push_back(words);
    }
  } else {
    const Way sent = way(block, end);
    pen.lines = block.arc() != nullptr || (block.straight_on_part && sent.ends.size() > 1);
    within_tolerance = sent.within_tolerance;
    for (const Solution& solution : sent.ends) {
      check(solution.programmed, solution);
      pieces.push_back(words(block, solution, &solution == &sent.ends.back(), pen));
      count(solution);
      last_ = solution;
    }
    feed = new_feed(block, pen.before, end.ticks, pieces.size());
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
    // A block that says its code leaves the modal one as it was meant.
    if (centre && (block.motion_word.stands() || !lines_since_arc_)) feed.arc_code = 0;
  }
  lines_since_arc_ = block.arc() != nullptr && !centre;
  if (!pieces.empty()) {
    rewrite(block, pieces.front(), feed);
    if (pieces.size() > 1 || feed.timed) {
      end_line(block);
      for (std::size_t i = 1; i < pieces.size(); ++i) insert(block, pieces[i], feed);
      if (feed.timed) restore_feed(block);
    }
  }
  ++out_.counts.corrected_blocks;
  if (!within_tolerance) ++out_.counts.beyond_tolerance;
  if (whole || centre) {
    count(end);
    last_ = end;
  }
  ticks_ = end.ticks;
  ticks_unit_mm_ = block.unit_mm;
}

void ChunkWriter::count(const Solution& solution) {
  CorrectionCounts& counts = out_.counts;
  counts.largest_deviation_mm = std::max(counts.largest_deviation_mm, solution.linear.deviation_mm);
  counts.largest_tilt_rad = std::max(counts.largest_tilt_rad, solution.linear.error.rotation_rad.norm());
  counts.largest_residual_rad = std::max(counts.largest_residual_rad, solution.residual.in_radians());
  counts.largest_c_correction_rad = std::max(counts.largest_c_correction_rad, std::abs(solution.turn_by.in_radians()));
  if (last_) {
    counts.largest_position_change_mm =
        std::max(counts.largest_position_change_mm, (solution.linear.change_mm - last_->linear.change_mm).norm());
    for (const Angle change : {solution.tilt_by - last_->tilt_by, solution.turn_by - last_->turn_by})
      counts.largest_rotary_change_rad = std::max(counts.largest_rotary_change_rad, std::abs(change.in_radians()));
  }
}

void ChunkWriter::set_position(const MotionBlock& block) {
  const Ticks now = ticks_before(block);
  NewWords words;
  for (std::size_t i = 0; i < kAxes; ++i)
    if (holds(block.programmed, i)) words[i] = block.word[i].value + now[i];
  rewrite_numbers(block, words);
}

// --- writing
// ----------------------------------------------------------------------------------------------------------

void ChunkWriter::copy_to(std::uint32_t place) {
  out_.text.append(source_.substr(copied_, place - copied_));
  copied_ = place;
}

const WordPlace* ChunkWriter::word_of(const MotionBlock& block, std::size_t slot) const {
  if (slot < kAxes) return holds(block.programmed, slot) ? &block.word[slot] : nullptr;
  return block.extras->direction ? &(*block.extras->direction)[slot - kAxes] : nullptr;
}

void ChunkWriter::append_number_in(Decimal number, NumberStyle style) {
  style.plus |= text_.sign_always;
  style.point |= text_.point_always;
  append_number(out_.text, number, style);
}

void ChunkWriter::replace_number(const WordPlace& word, Decimal value) {
  copy_to(word.number);
  append_number_in(value, word.style);
  copied_ = word.number_end;
  ++out_.counts.changed_words;
}

/// A word of axis or vector, dressed as the block's own word is: its letter, its =IC( ), its I.
void ChunkWriter::append_word(const MotionBlock& block, std::size_t slot, Decimal value, bool blank) {
  if (blank) out_.text += ' ';
  if (const WordPlace* own = word_of(block, slot)) {
    out_.text.append(source_.substr(own->text, own->number - own->text));
    append_number_in(value, own->style);
    out_.text.append(source_.substr(own->number_end, own->end - own->number_end));
    return;
  }
  if (slot < kAxes) {
    const bool small = block.words > 0 && source_[block.word[block.order[0]].text] >= 'a';
    out_.text += static_cast<char>(small ? letters_[slot] - 'A' + 'a' : letters_[slot]);
    append_number_in(value, block.style[slot]);
  } else {
    out_.text.append(text_.direction[slot - kAxes]);
    append_number_in(value, {});
  }
}

void ChunkWriter::append_feed(const MotionBlock& block, const NewFeed& feed, bool blank) {
  if (blank && block.blank_before_words) out_.text += ' ';
  out_.text += feed.timed && text_.time_in_seconds ? "FT" : "F";
  NumberStyle style = block.has_feed_word() ? block.feed_word.style : NumberStyle{};
  style.plus = false;
  append_number(out_.text, *feed.word, style);
}

/// The usual block: absolute words of the axes, whose numbers change. False, and nothing written, for any other.
bool ChunkWriter::rewrite_plainly(const MotionBlock& block, const Solution& end, const Ticks& before) {
  constexpr std::size_t kRoom = 512;
  if (block.extras || block.words == 0 || (block.incremental | block.in_turn) != 0 ||
      block.end - copied_ + kAxes * kLongestNumber > kRoom)
    return false;
  for (std::size_t i = 0; i < kAxes; ++i)
    if (!holds(block.programmed, i) && !same(end.ticks[i], before[i])) return false;
  std::array<char, kRoom> line;
  char* to = line.data();
  const char* const source = source_.data();
  for (std::size_t i = 0; i < block.words; ++i) {
    const std::size_t axis = block.order[i];
    if (end.ticks[axis].mantissa == 0) continue;
    const WordPlace& word = block.word[axis];
    to = std::copy(source + copied_, source + word.number, to);
    NumberStyle style = word.style;
    style.plus |= text_.sign_always;
    style.point |= text_.point_always;
    to = write_number(to, word.value + end.ticks[axis], style);
    copied_ = word.number_end;
    ++out_.counts.changed_words;
  }
  out_.text.append(line.data(), to);
  return true;
}

/// A few numbers change, words are added behind the last.
void ChunkWriter::rewrite_numbers(const MotionBlock& block, const NewWords& words) {
  // Vectors stand before or behind the axes; the general way puts them in order.
  if (block.words == 0 || (block.extras && block.extras->direction)) return rewrite(block, words, {});
  std::uint32_t last_word = block.begin;
  for (std::size_t i = 0; i < block.words; ++i) {
    const std::size_t axis = block.order[i];
    const WordPlace& word = block.word[axis];
    last_word = word.end;
    if (words[axis] && !same(*words[axis], word.value)) replace_number(word, *words[axis]);
  }
  bool add = false;
  for (std::size_t i = 0; i < kWords; ++i) add |= words[i] && (i >= kAxes || !holds(block.programmed, i));
  if (!add) return;
  copy_to(last_word);
  add_words(block, words, {}, false);
}

/// Words that the block has not, or all.
void ChunkWriter::add_words(const MotionBlock& block, const NewWords& words, const NewFeed& feed, bool all) {
  bool blank = all ? text_.function_in_every_block : block.blank_before_words;
  for (std::size_t i = 0; i < kWords; ++i) {
    if (!words[i] || (!all && word_of(block, i) != nullptr)) continue;
    append_word(block, i, *words[i], blank);
    if (!all) ++out_.counts.added_words;
    blank = block.blank_before_words;
  }
  if (feed.word && (all || !block.has_feed_word())) append_feed(block, feed, true);
}

/// The code of a straight move or an arc, written as the block writes its own: G1, G01, g1.
std::string ChunkWriter::arc_code(const MotionBlock& block, char digit) const {
  if (text_.function_in_every_block && digit == '1') return std::string(text_.line_code);
  if (digit != '1' && !block.extras->arc_name.empty()) return std::string(block.extras->arc_name);
  const std::string_view own = source_.substr(block.motion_word.text, block.motion_word.end - block.motion_word.text);
  const bool plain = own.size() >= 2 && own[1] >= '0' && own[1] <= '9';
  const char letter = plain ? own[0] : 'G';
  return std::string(1, letter) + (plain && own.size() == 3 && own[1] == '0' ? "0" : "") + digit;
}

void ChunkWriter::rewrite(const MotionBlock& block, const NewWords& words, const NewFeed& feed) {
  struct Edit {
    std::uint32_t text, number, number_end, end;  // of the word
    std::optional<Decimal> value;                 // its new number; none: `whole` stands in its place
    NumberStyle style;
    std::string whole;  // empty: the word goes
    bool axis = true;   // its number is a coordinate
  };
  std::vector<Edit> edits;
  std::uint32_t first_word = block.end, last_word = block.begin;
  const auto number = [&](const WordPlace& word, Decimal value, NumberStyle style) {
    edits.push_back({word.text, word.number, word.number_end, word.end, value, style, {}});
  };
  const auto replace = [&](std::uint32_t text, std::uint32_t end, std::string whole) {
    edits.push_back({text, text, end, end, std::nullopt, {}, std::move(whole)});
  };
  const auto anchor = [&](const WordPlace& word) {
    first_word = std::min(first_word, word.text);
    last_word = std::max(last_word, word.end);
  };
  for (std::size_t i = 0; i < kWords; ++i) {
    if (i >= kAxes && !block.extras) break;
    const WordPlace* word = word_of(block, i);
    if (word == nullptr) continue;
    anchor(*word);
    if (words[i] && !same(*words[i], word->value)) {
      number(*word, *words[i], word->style);
      ++out_.counts.changed_words;
    }
  }
  if (block.extras)
    for (const ArcWord& own : block.extras->arc_word) {
      anchor(own.word);
      if (feed.lines_for_arc) {
        replace(own.word.text, own.word.end, {});
        ++out_.counts.changed_words;
      } else if (own.tells != ArcWord::Tells::nothing_moved) {
        Decimal by = rounded(feed.centre_mm[own.axis] / block.unit_mm, block.decimals[own.axis]);
        const Ticks before = ticks_before(block);
        if (own.tells == ArcWord::Tells::centre_from_begin) by = by - before[own.axis];
        if (by.mantissa == 0) continue;
        number(own.word, own.word.value + by, own.word.style);
        ++out_.counts.changed_words;
      }
    }
  if (feed.word && block.has_feed_word()) {
    if (feed.timed && text_.time_in_seconds) {
      std::string time = "FT";
      append_number(time, *feed.word, {});
      replace(block.feed_word.text, block.feed_word.end, time);
    } else {
      number(block.feed_word, *feed.word, block.feed_word.style);
      edits.back().axis = false;
    }
  }
  const bool mode_word = block.extras && block.extras->feed_mode_word.stands();
  const bool reciprocal = feed.timed && !text_.time_in_seconds;
  if (reciprocal && mode_word) replace(block.extras->feed_mode_word.text, block.extras->feed_mode_word.end, "G93");
  const std::string code = feed.arc_code == 0 ? "" : arc_code(block, feed.arc_code);
  if (!code.empty() && block.motion_word.stands()) replace(block.motion_word.text, block.motion_word.end, code);

  // Words to be added stand behind the last word of the move, codes before the first.
  const bool add_mode = reciprocal && !mode_word;
  const bool add_code = !code.empty() && !block.motion_word.stands();
  bool add = feed.word && !block.has_feed_word();
  for (std::size_t i = 0; i < kWords; ++i) add |= words[i] && word_of(block, i) == nullptr;
  std::ranges::sort(edits, {}, &Edit::text);
  if (last_word == block.begin) first_word = last_word = std::max(block.motion_word.end, block.begin);

  std::size_t next = 0;
  const auto edit_before = [&](std::uint32_t place) {
    for (; next < edits.size() && edits[next].text < place; ++next) {
      const Edit& edit = edits[next];
      if (edit.value) {
        copy_to(edit.number);
        edit.axis ? append_number_in(*edit.value, edit.style) : append_number(out_.text, *edit.value, edit.style);
        copied_ = edit.number_end;
        continue;
      }
      copy_to(edit.text);
      if (edit.whole.empty())
        while (out_.text.ends_with(' ') || out_.text.ends_with('\t')) out_.text.pop_back();
      out_.text += edit.whole;
      copied_ = edit.end;
    }
  };
  if (add_mode || add_code) {
    edit_before(first_word);
    copy_to(first_word);
    const std::string_view apart = block.blank_before_words ? " " : "";
    if (add_mode) out_.text.append("G93").append(apart);
    if (add_code) out_.text.append(code).append(apart);
    out_.counts.added_words += add_code;
  }
  if (add) {
    edit_before(last_word);
    copy_to(std::max(last_word, copied_));
    add_words(block, words, feed, false);
  }
  edit_before(block.end);
}

void ChunkWriter::end_line(const MotionBlock& block) {
  copy_to(block.end);
  if (line_end(source_.substr(block.begin, block.end - block.begin)).empty()) out_.text += '\n';
}

/// Where every block names its function: the number of the block and the function.
void ChunkWriter::append_block_begin(const MotionBlock& block) {
  if (!text_.function_in_every_block) return;
  const std::uint32_t function = block.motion_word.text;
  out_.text.append(source_.substr(block.begin, function - block.begin));
  const std::string_view own = source_.substr(function, block.motion_word.end - function);
  out_.text.append(block.arc() != nullptr ? text_.line_code : own);
}

void ChunkWriter::insert(const MotionBlock& block, const NewWords& words, const NewFeed& feed) {
  append_block_begin(block);
  add_words(block, words, feed, true);
  insert_line_end(block);
}

void ChunkWriter::restore_feed(const MotionBlock& block) {
  if (text_.time_in_seconds) {
    // FT holds for its block; an F that the block said is said again for those that follow.
    if (!block.has_feed_word()) return;
    append_block_begin(block);
    out_.text += ' ';
    append_feed(block, {.word = feed_decimal(block.feed)}, false);
    return insert_line_end(block);
  }
  // F counts in the units of the block that says it, as mm for X Y Z and as degrees for the rotary axes.
  const bool other_unit = block.feed_unit_mm != block.unit_mm;
  if (other_unit) {
    out_.text += block.feed_unit_mm == 1 ? "G21" : "G20";
    insert_line_end(block);
  }
  out_.text += "G94";
  append_feed(block, {.word = feed_decimal(block.feed)}, true);
  insert_line_end(block);
  if (other_unit) {
    out_.text += block.unit_mm == 1 ? "G21" : "G20";
    insert_line_end(block);
  }
}

void ChunkWriter::insert_line_end(const MotionBlock& block) {
  const std::string_view end = line_end(source_.substr(block.begin, block.end - block.begin));
  if (text_.semicolon_ends_block && source_.substr(block.begin, block.end - block.begin).find(';') != std::string::npos)
    out_.text += ';';
  out_.text += end.empty() ? "\n" : end;
  ++out_.counts.inserted_blocks;
  if (out_.inserted.empty() || out_.inserted.back().line != block.line) out_.inserted.push_back({block.line, 0});
  ++out_.inserted.back().count;
}

}  // namespace trunnion
