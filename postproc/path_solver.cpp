#include "postproc/path_solver.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "error.h"
#include "postproc/tool_axis.h"

namespace trunnion {
namespace {

using Eigen::Vector3d;

constexpr double kAbsurd_mm = 1000;  // no limit of a machine file lets this through
constexpr double kAngleRounding_deg = 1e-9;
constexpr double kStrokeRounding_mm = 1e-9;
/// Moves shorter than both need no look at their middle: the correction bends by its second difference, and 2 deg of a
/// 30 um error scale bend 0.003 um.
constexpr double kStraight_deg = 2;
constexpr double kStraight_mm = 20;
constexpr double kSameAxis_rad = 1e-9, kOpposite_rad = 1e-3;

/// The rotary axes after the part `s` of a way on which the tool axis goes the great circle between its ends.
IndexedPosition on_great_circle(const KinematicChain& chain, IndexedPosition from, IndexedPosition to, double s) {
  const IndexedPosition straight{from.a + s * (to.a - from.a), from.c + s * (to.c - from.c)};
  const Vector3d begin = tool_axis_w(chain, from), end = tool_axis_w(chain, to);
  const double angle = std::atan2(begin.cross(end).norm(), begin.dot(end));
  if (angle < kSameAxis_rad || s <= 0 || s >= 1) return straight;
  if (angle > std::numbers::pi - kOpposite_rad)
    throw RefusalError("the tool turns about, and by which way is not told; post shorter moves");
  const Vector3d axis = (std::sin((1 - s) * angle) * begin + std::sin(s * angle) * end).normalized();
  // The branch that the ends are on.
  IndexedPosition nearest = straight;
  double least = 1e300;
  for (const AxisSolution& way : rotary_positions_for(chain, axis, straight.c)) {
    const double away = std::abs((way.at.a - straight.a).in_radians()) + std::abs((way.at.c - straight.c).in_radians());
    if (away < least) least = away, nearest = way.at;
  }
  return nearest;
}

/// `at` with the rotary axes where their words can say them: the position is then solved for the angles that are
/// written.
AxisValues on_grid(const MotionBlock& block, AxisValues at) {
  for (const std::size_t i : {kTilt, kTurn})
    at[i] = block.zero[i] + rounded(at[i] - block.zero[i], block.decimals[i]).value();
  return at;
}

/// The centre of an arc that keeps its radius and its side while its ends are moved, in the height of its begin; none
/// where the radius does not reach.
std::optional<Vector3d> same_radius(const Arc& arc, const Vector3d& at_begin, const Vector3d& at_end,
                                    const AxisValues& target) {
  const Vector3d normal = arc.along.cross(arc.across).normalized();
  const Vector3d begin = arc.centre + arc.along, end(target[0], target[1], target[2]);
  const auto flat = [&](const Vector3d& v) { return Vector3d(v - normal * normal.dot(v)); };
  const Vector3d meant = flat(end - begin), moved = flat(end + at_end - begin - at_begin);
  const double height2 = arc.along.squaredNorm() - 0.25 * moved.squaredNorm();
  if (height2 < 0) return std::nullopt;
  const double side = normal.cross(meant).dot(-arc.along - 0.5 * meant) < 0 ? -1 : 1;
  return begin + at_begin + 0.5 * moved + side * std::sqrt(height2) * normal.cross(moved).normalized();
}

/// Chords that keep within `tolerance_mm` of an arc, which leaves a tenth of it for the correction's own bend.
int chords(const Arc& arc, double tolerance_mm) {
  const double step = 2 * std::acos(std::max(0.0, 1 - 0.9 * tolerance_mm / arc.along.norm()));
  return std::max(1, static_cast<int>(std::min(1e6, std::ceil(std::abs(arc.sweep_rad) / step))));
}

}  // namespace

Vector3d out_of_frame(const MotionBlock& block, const Vector3d& v) {
  const ProgramFrame* frame = block.frame();
  return frame != nullptr ? Vector3d(frame->rotation * v) : v;
}
Vector3d into_frame(const MotionBlock& block, const Vector3d& v) {
  const ProgramFrame* frame = block.frame();
  return frame != nullptr ? Vector3d(frame->rotation.transpose() * v) : v;
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

Commanded PathSolver::commanded(const MotionBlock& block, const AxisValues& at) const {
  Commanded place{Vector3d(at[0], at[1], at[2]),
                  {Angle::degrees(at[kTilt]), Angle::degrees(at[kTurn])},
                  block.tilt_sense,
                  block.turn_sense,
                  block.linear_sense,
                  block.time_s};
  if (const ProgramFrame* frame = block.frame()) place.xyz_mm = frame->origin_mm + frame->rotation * place.xyz_mm;
  return place;
}

/// Where the programmed path is between two places of it.
AxisValues PathSolver::place_between(const MotionBlock& block, const AxisValues& from, const AxisValues& to,
                                     double s) const {
  AxisValues at = between(from, to, s);
  if (s >= 1) return at;
  if (block.turning == ToolTurning::great_circle) {
    const auto rotary = [](const AxisValues& v) {
      return IndexedPosition{Angle::degrees(v[kTilt]), Angle::degrees(v[kTurn])};
    };
    const IndexedPosition turned = on_great_circle(corrector(block).chain(), rotary(from), rotary(to), s);
    at[kTilt] = turned.a.in_degrees();
    at[kTurn] = turned.c.in_degrees();
  }
  if (!block.straight_on_part) return at;
  const Vector3d xyz =
      sent_between(block, commanded(block, from), commanded(block, to), s).xyz_mm;  // such blocks have no frame
  for (std::size_t i = 0; i < 3; ++i) at[i] = xyz[static_cast<Eigen::Index>(i)];
  return at;
}

/// Where the programmed path is after the part `s` of its way.
AxisValues PathSolver::on_way(const MotionBlock& block, double s) const {
  return with_arc(block.arc(), place_between(block, block.from, block.target, s), s);
}

Commanded PathSolver::sent_between(const MotionBlock& block, const Commanded& from, const Commanded& to,
                                   double s) const {
  Commanded at = to;
  at.rotary.a = from.rotary.a + s * (to.rotary.a - from.rotary.a);
  at.rotary.c = from.rotary.c + s * (to.rotary.c - from.rotary.c);
  if (block.turning == ToolTurning::great_circle)
    at.rotary = on_great_circle(corrector(block).chain(), from.rotary, to.rotary, s);
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
bool PathSolver::turns(const MotionBlock& block) const {
  return !block.rotary_fixed && with_tcp_.settings().orientation == Orientation::corrected;
}

void PathSolver::solve(const MotionBlock& block, const AxisValues& at, Solution& solution) const {
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

Solution PathSolver::solved(const MotionBlock& block, const AxisValues& at) const {
  Solution solution;
  solve(block, at, solution);
  return solution;
}

void PathSolver::check(const AxisValues& at, const Solution& solution) const {
  const double deviation = solution.linear.deviation_mm, tilt2 = solution.linear.error.rotation_rad.squaredNorm();
  if (deviation > guard_.limits.deviation.in_millimetres())
    throw RangeError("deviation " + text_of(deviation * 1e3, 1) + " um, limits.correction_um is " +
                     text_of(guard_.limits.deviation.in_micrometres(), 3));
  if (tilt2 > squared(guard_.limits.tilt.in_radians()))
    throw RangeError("tilt " + text_of(std::sqrt(tilt2) * 1e6, 1) + " urad, limits.correction_urad is " +
                     text_of(guard_.limits.tilt.in_microradians(), 3));
  const Vector3d slides = with_tcp_.slides_mm(solution.linear.tip_r_mm, solution.commanded.rotary);
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
void PathSolver::check_change(const Solution& before, const Solution& now) const {
  const double change2 = (now.linear.change_mm - before.linear.change_mm).squaredNorm();
  if (change2 > squared(guard_.change.in_millimetres()))
    throw RangeError("the correction changes by " + text_of(std::sqrt(change2) * 1e3, 1) +
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
double PathSolver::tilt_left_rad(const MotionBlock& block, const Commanded& wanted, const Commanded& sent) const {
  // Where the rotary axes stand, their correction does.
  if (block.from_known && turn_deg(block.from, block.target) == 0) return 0;
  const Corrector& judge = corrector(block);
  return (judge.tilt_error(wanted, sent.rotary) - judge.rotary(wanted).residual).in_radians();
}

bool PathSolver::holds_between(const MotionBlock& block, const Solution& from, double from_part, const Solution& to,
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

std::optional<Eigen::Vector3d> PathSolver::moved_arc(const MotionBlock& block, const Ticks& before,
                                                     const Solution& end) const {
  const Arc& meant = *block.arc();
  const bool unmoved = std::ranges::all_of(end.ticks, [](Decimal t) { return t.mantissa == 0; }) &&
                       std::ranges::all_of(before, [](Decimal t) { return t.mantissa == 0; });
  if (!block.extras->arc_movable && !unmoved) return std::nullopt;
  Vector3d at_begin, at_end, centre;
  bool by_centre = false, equal = true;
  bool by_radius = block.extras->arc_movable && block.extras->arc_name.empty();
  for (const ArcWord& word : block.extras->arc_word)
    by_centre |= word.tells == ArcWord::Tells::centre || word.tells == ArcWord::Tells::centre_from_begin;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Index axis = static_cast<Eigen::Index>(i);
    at_begin[axis] = before[i].value() * block.unit_mm;
    at_end[axis] = end.ticks[i].value() * block.unit_mm;
    equal &= same_value(before[i], end.ticks[i]);
    centre[axis] = rounded(0.5 * (before[i].value() + end.ticks[i].value()), block.decimals[i]).value() * block.unit_mm;
  }
  const Vector3d normal = meant.along.cross(meant.across).normalized();
  Arc sent = meant;
  if (by_centre || equal) {
    // The third axis has no centre.
    sent.centre += centre - normal * normal.dot(centre - at_begin);
  } else if (by_radius) {
    const std::optional<Vector3d> round = same_radius(meant, at_begin, at_end, block.target);
    if (!round) return std::nullopt;
    sent.centre = *round;
  } else {
    return std::nullopt;
  }
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
    AxisValues at = with_arc(&sent, place_between(block, block.from, block.target, s), s);
    for (const std::size_t i : {kTilt, kTurn})
      at[i] += before[i].value() + s * (end.ticks[i].value() - before[i].value());
    const Commanded there = commanded(block, at);
    if (corrector(block).tip_error_mm(wanted, there) > guard_.tolerance_mm) return std::nullopt;
    if (turns(block) && tilt_left_rad(block, wanted, there) > guard_.tolerance_rad) return std::nullopt;
  }
  return centre;
}

bool PathSolver::leaps(const Solution& before, const Solution& now) const {
  return (now.linear.change_mm - before.linear.change_mm).norm() > guard_.tolerance_mm ||
         std::abs((now.tilt_by - before.tilt_by).in_radians()) > guard_.tolerance_rad ||
         std::abs((now.turn_by - before.turn_by).in_radians()) > guard_.tolerance_rad;
}

bool PathSolver::is_short(const MotionBlock& block) const {
  if (block.kind != BlockKind::feed || !block.from_known) return true;
  return block.arc() == nullptr && turn2_deg2(block.from, block.target) <= squared(kStraight_deg) &&
         length2_mm2(block.from, block.target) <= squared(kStraight_mm);
}

Way PathSolver::way(const MotionBlock& block, const Solution& end) const {
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
    if (way.within_tolerance && n == 1) return way;
    if (block.turning == ToolTurning::not_told && turn_deg(block.from, block.target) > 0)
      throw RefusalError(
          "how the tool turns between two axes told as vectors is not known; program ORIAXES or ORIVECT, say "
          "orientation_path under [control] of the machine file, or post shorter moves");
    if (way.within_tolerance || n >= most) return way;
    // A chord's error falls with the square of its length.
    const double excess = std::max(tip_mm / guard_.tolerance_mm, tilt_rad / guard_.tolerance_rad);
    n = std::min(most, std::max(n + 1, static_cast<int>(std::ceil(n * std::sqrt(std::min(excess, 1e6))))));
  }
}

}  // namespace trunnion
