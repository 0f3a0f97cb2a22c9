#include "postproc/slide_senses.h"

#include <cmath>

namespace trunnion {
namespace {

using Eigen::Vector3d;

constexpr double kStill_mm = 1e-3;
constexpr double kParts[] = {0.25, 0.5, 0.75, 0.9, 1};  // a slide may turn about within a block

Vector3d xyz(const AxisValues& at) { return {at[0], at[1], at[2]}; }

}  // namespace

Vector3d SlideSenses::slides_mm(const MotionBlock& block, const AxisValues& at) const {
  Vector3d place = xyz(at);
  if (const ProgramFrame* frame = block.frame()) place = frame->origin_mm + frame->rotation * place;
  if (!block.tcp) return place;
  const IndexedPosition rotary{Angle::degrees(at[kTilt]), Angle::degrees(at[kTurn])};
  return chain_->r_from_w(rotary) * place - chain_->r_from_t(rotary) * Vector3d(0, 0, -tool_length_mm_);
}

void SlideSenses::follow(MotionBlock& block) {
  if (!block.from_known) {
    sense_ = {};
    from_mm_ = slides_mm(block, block.target);
  } else {
    AxisSet moved = 0;
    for (const double part : kParts) {
      if (part < 1 && block.kind == BlockKind::rapid) continue;
      const Vector3d to = slides_mm(block, with_arc(block.arc(), between(block.from, block.target, part), part));
      for (std::size_t i = 0; i < 3; ++i) {
        const Eigen::Index axis = static_cast<Eigen::Index>(i);
        const double way = to[axis] - from_mm_[axis];
        if (way * sense_[i] <= 0 && std::abs(way) <= kStill_mm) continue;
        if (way * sense_[i] < 0 && holds(moved, i)) block.turns_round |= only(i);
        moved |= only(i);
        sense_[i] = way > 0 ? 1 : -1;
        from_mm_[axis] = to[axis];
      }
    }
  }
  block.linear_sense = sense_;
}

double block_seconds(const MotionBlock& block) {
  if (block.kind != BlockKind::feed || !block.from_known || block.feed <= 0) return 0;
  if (block.feed_mode == FeedMode::inverse_time) return 60 / block.feed;
  if (block.feed_mode != FeedMode::per_minute) return 0;
  const Arc* arc = block.arc();
  const double way_mm = arc == nullptr ? (xyz(block.target) - xyz(block.from)).norm()
                                       : std::hypot(arc->sweep_rad * arc->along.norm(), arc->rise.norm());
  if (way_mm > 0) return 60 * way_mm / (block.feed * block.feed_unit_mm);
  return 60 * std::hypot(block.target[kTilt] - block.from[kTilt], block.target[kTurn] - block.from[kTurn]) / block.feed;
}

}  // namespace trunnion
