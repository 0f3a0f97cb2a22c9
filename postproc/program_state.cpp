#include "postproc/program_state.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>

namespace trunnion {
namespace {

using Eigen::Vector3d;

constexpr int kFinestDecimals = 6;  // of a corrected word, however many the program shows
constexpr int kAngleDecimals = 6;   // where the angles themselves are not written
constexpr double kRadiusSlack_mm = 0.01;
constexpr double kSameAngle_deg = 1e-3;

double turn_apart(double a_deg, double b_deg) { return std::abs(std::remainder(a_deg - b_deg, 360)); }

Vector3d linear(const AxisValues& at) { return {at[0], at[1], at[2]}; }

/// A circle about `centre` whose quarter turn from `from` is along `normal` x (from - centre).
Arc circle(const Vector3d& centre, const Vector3d& normal, const Vector3d& from) {
  Arc arc;
  arc.along = from - centre;
  arc.centre = centre;
  arc.across = normal.cross(arc.along);
  return arc;
}

/// The circle from `from` over `through` to `to`, anywhere in space.
Arc circle_through(const Vector3d& from, const Vector3d& through, const Vector3d& to) {
  const Vector3d a = through - from, b = to - from, n = a.cross(b);
  if (n.squaredNorm() < 1e-12 * a.squaredNorm() * b.squaredNorm() || n.squaredNorm() == 0)
    bad("an arc whose three points lie on a line");
  const Vector3d centre = from + (b.squaredNorm() * n.cross(a) + a.squaredNorm() * b.cross(n)) / (2 * n.squaredNorm());
  Arc arc = circle(centre, n.normalized(), from);
  const Vector3d end = to - centre;
  arc.sweep_rad = std::atan2(end.dot(arc.across), end.dot(arc.along));
  if (arc.sweep_rad <= 0) arc.sweep_rad += kTurn_rad;
  return arc;
}

}  // namespace

void refuse(const std::string& what) { throw LineRefused{what, Refusal::Kind::refused, true}; }
void refuse_move(const std::string& what) { throw LineRefused{what}; }
void bad(const std::string& what) { throw LineRefused{what, Refusal::Kind::bad_input}; }

void refuse_corrected() {
  throw LineRefused{"this program has been corrected already; correct the original", Refusal::Kind::for_good};
}

std::size_t find_mark(std::string_view text) {
  const auto same = [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; };
  const auto found = std::search(text.begin(), text.end(), kCorrectedMark.begin(), kCorrectedMark.end(), same);
  return found == text.end() ? std::string_view::npos : static_cast<std::size_t>(found - text.begin());
}

bool contains_mark(std::string_view comment) { return find_mark(comment) != std::string_view::npos; }

void Move::clear() {
  kind = Kind::rapid;
  block.clear();
  if (has_extras) {
    extras = {};
    has_extras = false;
    arc = {};
  }
  shortest = explicit_increments = 0;
  computed = {};
  tool_axis.reset();
}

void Move::add(std::size_t axis, const WordPlace& word, char letter) {
  if (holds(block.programmed, axis)) bad(std::string(1, letter) + " stands twice in one block");
  block.programmed |= only(axis);
  block.word[axis] = word;
  block.order[block.words++] = static_cast<std::uint8_t>(axis);
}

ProgramState::ProgramState(const ScanSettings& settings) : settings_(settings), tcp_(settings.tcp) {
  if (settings_.control.turn_path == "shortest") turn_shortest = true;
  if (settings_.follow_senses) slides_.emplace(*settings_.chain, settings_.tool_length_mm);
}

// --- zeros and frames
// -----------------------------------------------------------------------------------------------

void ProgramState::select_offset(std::string code) {
  if (in_plane()) refuse(code + " in a tilted plane");
  system_ = std::move(code);
  offset_known_ = false;
}

AxisValues& ProgramState::shift() {
  if (!plane_waits_.empty()) refuse("a shift of the zero between " + plane_waits_ + " and the turn to its plane");
  return shift_;
}

double ProgramState::work_zero(std::size_t axis) {
  if (axis >= 3 || plane_frame_) return 0;
  if (!offset_known_) {
    offset_ = {};
    if (!settings_.work_offsets_mm.empty() && system_ != "G500") {
      const auto found = settings_.work_offsets_mm.find(system_);
      if (found == settings_.work_offsets_mm.end()) refuse_move(system_ + ": the job gives no work offset for it");
      offset_ = found->second;
    }
    offset_known_ = true;
  }
  return offset_[axis];
}

double ProgramState::zero(std::size_t axis) {
  return work_zero(axis) + shift_[axis] + (axis == kTurn ? turns_deg_ : 0);
}

const ProgramFrame* ProgramState::frame() const {
  if (plane_frame_) return &*plane_frame_;
  return tcp_ && tcp_frame_ ? &*tcp_frame_ : nullptr;
}

void ProgramState::new_frame() {
  frame_only_.reset();
  tangent_.reset();
  forget(kLinearAxes);
}

void ProgramState::set_tcp(bool on, const std::string& name) {
  if (settings_.tcp_forced || tcp_ == on) return;
  if (in_plane()) refuse(name + " in a tilted plane");
  tcp_ = on;
  tcp_frame_.reset();
  if (on && settings_.control.tcp_frame == "start") {
    if (!knows(kTilt) || !knows(kTurn))
      refuse(name +
             ": the frame stands as the table lies here, and where its axes stand is not known; program them before");
    const IndexedPosition at{Angle::degrees(at_[kTilt]), Angle::degrees(at_[kTurn])};
    const Eigen::Isometry3d w_from_r = settings_.chain->r_from_w(at).inverse();
    if (!w_from_r.isApprox(Eigen::Isometry3d::Identity(), 1e-15))
      tcp_frame_ = ProgramFrame{w_from_r.linear(), w_from_r.translation()};
  }
  new_frame();
}

void ProgramState::define_plane(const Eigen::Matrix3d& rotation, const Vector3d& origin_mm, const std::string& name) {
  leave_plane();
  if (tcp_ && frame() != nullptr) refuse(name + " in a frame of tool-centre-point control that is turned itself");
  const Vector3d zero_mm(work_zero(0) + shift_[0], work_zero(1) + shift_[1], work_zero(2) + shift_[2]);
  plane_frame_ = ProgramFrame{rotation, zero_mm + origin_mm};
  shift_outside_ = shift_;
  for (std::size_t i = 0; i < 3; ++i) shift_[i] = 0;
  plane_waits_ = name;
  new_frame();
}

void ProgramState::turn_to_plane(const std::string& name, int sense) {
  if (!plane_frame_) refuse(name + " without a tilted plane");
  std::vector<AxisSolution> ways = reachable(plane_frame_->rotation.col(2), name);
  if (sense != 0 && ways.size() > 1)
    std::erase_if(ways, [&](const AxisSolution& one) { return one.at.a.in_radians() * sense < 0; });
  const AxisSolution* way = ways.size() == 1 ? &ways.front() : nullptr;
  // Of two ways, the one on which the axes stand already.
  if (knows(kTilt) && knows(kTurn))
    for (const AxisSolution& one : ways)
      if (std::abs(one.at.a.in_degrees() - at_[kTilt]) < kSameAngle_deg &&
          turn_apart(one.at.c.in_degrees(), at_[kTurn]) < kSameAngle_deg)
        way = &one;
  if (way == nullptr)
    refuse(name + ": two ways lead to this plane, A and C of either sign; program the rotary axes before it");
  stand_at(*way);
  if (way->turn_free) forget(only(kTurn));
  raw_since_ |= kRotaryAxes;
  plane_waits_.clear();
}

void ProgramState::reduce_turn() {
  at_[kTurn] -= 360 * std::floor(at_[kTurn] / 360);
  turns_deg_ = 0;
}

void ProgramState::leave_plane() {
  if (!plane_frame_) return;
  plane_frame_.reset();
  plane_waits_.clear();
  for (std::size_t i = 0; i < 3; ++i) shift_[i] = shift_outside_[i];
  new_frame();
}

std::vector<AxisSolution> ProgramState::reachable(const Vector3d& axis_w, const std::string& name) const {
  std::vector<AxisSolution> ways =
      rotary_positions_for(*settings_.chain, axis_w, Angle::degrees(knows(kTurn) ? at_[kTurn] : 0));
  if (const auto& stroke = settings_.tilt_stroke_deg)
    std::erase_if(ways, [&](const AxisSolution& way) {
      const double tilt = way.at.a.in_degrees();
      return tilt < stroke->first - kSameAngle_deg || tilt > stroke->second + kSameAngle_deg;
    });
  if (ways.empty()) refuse_move(name + ": this machine cannot hold the tool that way");
  return ways;
}

void ProgramState::stand_at(const AxisSolution& way) {
  const double tilt = way.at.a.in_degrees(), turn = way.at.c.in_degrees();
  if (knows(kTilt) && tilt != at_[kTilt]) tilt_sense_ = tilt > at_[kTilt] ? 1 : -1;
  at_[kTilt] = tilt;
  known_ |= only(kTilt);
  if (way.turn_free) return;
  if (knows(kTurn) && turn != at_[kTurn]) turn_sense_ = turn > at_[kTurn] ? 1 : -1;
  at_[kTurn] = turn;
  known_ |= only(kTurn);
}

// --- blocks that move
// -----------------------------------------------------------------------------------------------

/// The axes whose words count, or would count, from the place before.
AxisSet ProgramState::counting(const Move& move) const {
  return static_cast<AxisSet>((incremental ? kAllAxes & ~move.block.wrapped : 0) | move.explicit_increments);
}

void ProgramState::place_words(const Move& move) {
  const MotionBlock& block = move.block;
  const AxisSet counting = this->counting(move);
  for (std::size_t i = 0; i < block.words; ++i) {
    const std::size_t axis = block.order[i];
    const WordPlace& word = block.word[axis];
    const double value = scale(axis) * word.value.value();
    style_[axis] = word.style;
    if (holds(counting, axis)) {
      at_[axis] += value;
      if (std::abs(at_[axis]) > kInch_mm * kFarthest)
        bad(std::string(1, settings_.letters[axis]) + " leads beyond any machine");
      continue;
    }
    double place = value + work_zero(axis) + shift_[axis];
    if (axis == kTurn) {
      const bool shorter = settings_.modulo_turn && knows(kTurn) && (turn_shortest || holds(move.shortest, axis));
      turns_deg_ = shorter ? 360 * std::round((at_[kTurn] - place) / 360) : 0;
      place += turns_deg_;
      const bool within = (turn_shortest || holds(move.shortest, axis)) && value >= 0 && value < 360;
      in_turn_ = within ? only(kTurn) : 0;
    }
    at_[axis] = place;
    known_ |= only(axis);
  }
  for (std::size_t i = 0; i < 3; ++i)
    if (move.computed[i]) at_[i] = *move.computed[i] + zero(i);
}

void ProgramState::take_tool_axis(const Move& move) {
  Vector3d axis = *move.tool_axis;
  if (!(axis.norm() > 1e-3)) bad("a tool axis without length");
  axis.normalize();
  if (const ProgramFrame* turned = frame()) axis = turned->rotation * axis;
  const std::vector<AxisSolution> ways = reachable(axis, "the tool axis");
  const AxisSolution* best = &ways.front();
  if (ways.size() > 1) {
    if (!knows(kTilt))
      refuse_move("the tool axis can be held by two tilts; program the rotary axes themselves before it");
    const auto away = [&](const AxisSolution& way) {
      return std::abs(way.at.a.in_degrees() - at_[kTilt]) +
             (knows(kTurn) ? turn_apart(way.at.c.in_degrees(), at_[kTurn]) : 0);
    };
    best = away(ways[0]) <= away(ways[1]) ? &ways[0] : &ways[1];
  }
  stand_at(*best);
  turns_deg_ = 0;
  if (!axis_by_vectors_) frame_only_.reset();
  axis_by_vectors_ = true;
}

void ProgramState::set_position(Move& move, std::uint64_t line, ScannedChunk& chunk) {
  if (in_plane()) refuse("G92 in a tilted plane");
  MotionBlock& block = move.block;
  describe(move, line);
  for (std::size_t i = 0; i < block.words; ++i) {
    const std::size_t axis = block.order[i];
    if (!knows(axis))
      refuse(std::string("G92 ") + settings_.letters[axis] + ": where the axis stands is not known here");
    shift_[axis] = at_[axis] - work_zero(axis) - scale(axis) * block.word[axis].value.value();
    if (axis == kTurn) turns_deg_ = 0;
  }
  block.kind = BlockKind::set_position;
  block.from = block.target = at_;
  block.raw_since = raw_since_;
  chunk.blocks.push_back(block);
}

void ProgramState::move(Move& move, std::uint64_t line, ScannedChunk& chunk) {
  MotionBlock& block = move.block;
  if (!plane_waits_.empty()) refuse_move("a move behind " + plane_waits_ + " before the tool was turned to its plane");
  if (in_plane() && ((block.programmed & kRotaryAxes) != 0 || move.tool_axis))
    refuse_move("a rotary axis moves in a tilted plane, which goes with the table; post that move outside the plane");
  const AxisSet known_before = known_;
  const AxisValues from = at_;
  place_words(move);
  if (move.tool_axis) take_tool_axis(move);
  if ((block.programmed & kRotaryAxes) != 0 && axis_by_vectors_) {
    axis_by_vectors_ = false;
    frame_only_.reset();
  }
  for (const std::size_t axis : {kTilt, kTurn}) {
    if (holds(known_before, axis) && at_[axis] != from[axis])
      (axis == kTilt ? tilt_sense_ : turn_sense_) = at_[axis] > from[axis] ? 1 : -1;
    if (!cutter.empty() && (holds(block.programmed, axis) || move.tool_axis) &&
        !(holds(known_before, axis) && at_[axis] == from[axis]))
      refuse_move(
          std::string(cutter) +
          " is active while a rotary axis moves: cutter radius compensation is not corrected there; post the tool's "
          "centre path");
  }
  if (known_ != kAllAxes) {
    if (move.kind == Move::Kind::arc && !block.motion_word.stands())
      refuse_move("an arc without its G2 or G3, in a place where not all axes are known");
    tangent_.reset();
    ++chunk.copied_moves;
    raw_since_ |= static_cast<AxisSet>(block.programmed & ~counting(move));
    return;
  }
  describe(move, line);
  if (move.kind == Move::Kind::arc) {
    if (known_before != kAllAxes) refuse_move("an arc in the block that first makes all axes known");
    move.extras.arc = arc(move, from);
    move.extras.direction_in_effect = axis_by_vectors_;
    move.extras.frame.reset();
    if (const ProgramFrame* turned = frame()) move.extras.frame = *turned;
    block.extras = std::make_shared<const BlockExtras>(move.extras);
    const Arc& made = *move.extras.arc;
    tangent_ = (made.sweep_rad * (std::cos(made.sweep_rad) * made.across - std::sin(made.sweep_rad) * made.along))
                   .normalized();
    if (block.straight_on_part && (at_[kTilt] != from[kTilt] || at_[kTurn] != from[kTurn]))
      refuse_move("an arc while the table turns in a frame that does not turn with it");
  } else if (const Vector3d way = linear(at_) - linear(from); known_before == kAllAxes && way.squaredNorm() > 0) {
    tangent_ = way.normalized();
  }
  block.kind = move.kind == Move::Kind::rapid ? BlockKind::rapid : BlockKind::feed;
  block.from = from;
  block.target = at_;
  block.from_known = known_before == kAllAxes;
  block.raw_since = raw_since_;
  raw_since_ = 0;
  if (slides_) slides_->follow(block);
  if (settings_.follow_time) {
    const double seconds = block_seconds(block);
    if (seconds == 0 && !(block.from_known && from == at_) && ++chunk.untimed_moves == 1)
      chunk.first_untimed_line = line;
    time_s_ += seconds;
    block.time_s = time_s_;
  }
  if (block.turning == ToolTurning::great_circle && (at_[kTilt] != from[kTilt] || at_[kTurn] != from[kTurn]))
    chunk.assumptions |= only(Assumption::great_circle);
  chunk.blocks.push_back(block);
}

Arc ProgramState::arc(const Move& move, const AxisValues& from) {
  const ArcTold& told = move.arc;
  const std::size_t a = plane[0], b = plane[1];
  const Vector3d begin = linear(from), end = linear(at_);
  if (told.through) {
    Vector3d through;
    for (std::size_t i = 0; i < 3; ++i) through[static_cast<Eigen::Index>(i)] = (*told.through)[i] + zero(i);
    return circle_through(begin, through, end);
  }
  const auto part = [](const Vector3d& v, std::size_t axis) { return v[static_cast<Eigen::Index>(axis)]; };
  const double chord_a = part(end, a) - part(begin, a), chord_b = part(end, b) - part(begin, b);
  const double chord = std::hypot(chord_a, chord_b);
  double sense = told.sense;
  Vector3d centre = begin;
  double& centre_a = centre[static_cast<Eigen::Index>(a)];
  double& centre_b = centre[static_cast<Eigen::Index>(b)];
  if (told.tangent) {
    if (!tangent_) refuse_move("an arc that goes on from a move which is not known");
    const double normal_a = -part(*tangent_, b), normal_b = part(*tangent_, a);
    const double across = chord_a * normal_a + chord_b * normal_b;
    if (std::abs(across) < 1e-9 * chord * std::hypot(normal_a, normal_b) || chord == 0)
      bad("an arc that goes on straight");
    const double far = chord * chord / (2 * across);
    centre_a += far * normal_a;
    centre_b += far * normal_b;
    sense = across > 0 ? 1 : -1;
  } else if (told.radius_mm) {
    const double radius = *told.radius_mm;
    if (chord == 0) bad("an arc by radius that ends where it begins");
    if (chord > 2 * std::abs(radius) + kRadiusSlack_mm) bad("an arc whose radius does not reach its end");
    const double height = std::sqrt(std::max(0.0, radius * radius - 0.25 * chord * chord));
    // Left of the chord for a counter-clockwise arc of less than half a turn.
    const double side = sense * (radius > 0 ? 1 : -1);
    centre_a += 0.5 * chord_a - side * height * chord_b / chord;
    centre_b += 0.5 * chord_b + side * height * chord_a / chord;
  } else {
    if (!told.centre[a] && !told.centre[b]) bad("an arc without centre or radius");
    for (const std::size_t axis : {a, b}) {
      double& place = centre[static_cast<Eigen::Index>(axis)];
      if (!holds(told.centre_absolute, axis))
        place += told.centre[axis].value_or(0);
      else if (told.centre[axis])
        place = *told.centre[axis] + zero(axis);
      else
        bad("an arc with an absolute centre wants both centre words");
    }
  }
  // The third axis turns with the plane's first two in the positive sense.
  Vector3d normal = Vector3d::Zero();
  normal[static_cast<Eigen::Index>(plane[2])] = 1;
  Arc arc = circle(centre, normal, begin);
  const double radius = arc.along.norm();
  if (radius == 0) bad("an arc of radius zero");
  arc.rise = normal * normal.dot(end - begin);
  const Vector3d to = end - arc.rise - centre;
  if (std::abs(to.norm() - radius) > std::max(kRadiusSlack_mm, 1e-3 * radius))
    bad("an arc whose end does not lie on it");
  arc.growth = to.norm() / radius - 1;
  double sweep = chord == 0 ? 0 : std::atan2(to.dot(arc.across), to.dot(arc.along));
  if (sense * sweep <= 1e-12) sweep += sense * kTurn_rad;
  if (told.sweep_rad) sweep = *told.sweep_rad;
  arc.sweep_rad = sweep + sense * kTurn_rad * told.turns.value_or(0);
  return arc;
}

ToolTurning ProgramState::turning_now() const {
  if (!tcp_ || in_plane()) return ToolTurning::axes;
  if (turning) return *turning;
  const std::string& path = settings_.control.orientation_path;
  if (path == "great circle") return ToolTurning::great_circle;
  return axis_by_vectors_ && path == "ask" ? ToolTurning::not_told : ToolTurning::axes;
}

void ProgramState::describe(Move& move, std::uint64_t line) {
  MotionBlock& block = move.block;
  block.line = line;
  block.tcp = tcp_ || in_plane();
  if (tcp_ && !in_plane() && !settings_.tcp_forced && settings_.control.tcp_frame == "fixed") {
    block.tcp = false;
    block.straight_on_part = true;
  }
  block.rotary_fixed = in_plane();
  block.turning = turning_now();
  block.cutter = !cutter.empty();
  block.incremental = counting(move);
  block.in_turn = in_turn_;
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    int least = settings_.decimals + (axis < 3 && unit_mm != 1 ? 2 : 0);
    if (axis >= 3 && axis_by_vectors_) least = std::max(least, kAngleDecimals);
    block.decimals[axis] =
        static_cast<std::uint8_t>(std::clamp<int>(style_[axis].decimals, least, std::max(least, kFinestDecimals)));
    block.zero[axis] = zero(axis);
  }
  block.style = style_;
  block.unit_mm = unit_mm;
  block.tilt_sense = tilt_sense_;
  block.turn_sense = turn_sense_;
  block.feed_mode = feed_mode;
  block.feed = feed_mode == FeedMode::inverse_time && !block.has_feed_word() ? 0 : feed;
  block.feed_unit_mm = feed_unit_mm;
  const ProgramFrame* turned = frame();
  if (move.has_extras && move.kind != Move::Kind::arc) {
    if (turned != nullptr) move.extras.frame = *turned;
    move.extras.direction_in_effect = axis_by_vectors_;
    block.extras = std::make_shared<const BlockExtras>(move.extras);
  } else if (turned != nullptr || axis_by_vectors_) {
    if (!frame_only_) {
      BlockExtras extras;
      if (turned != nullptr) extras.frame = *turned;
      extras.direction_in_effect = axis_by_vectors_;
      frame_only_ = std::make_shared<const BlockExtras>(std::move(extras));
    }
    block.extras = frame_only_;
  }
}

}  // namespace trunnion
