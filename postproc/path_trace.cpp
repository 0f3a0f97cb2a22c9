#include "postproc/path_trace.h"

#include <algorithm>

namespace trunnion {
namespace {

void join(PathStretch& into, const PathStretch& other) {
  into.tip_before_mm = std::max(into.tip_before_mm, other.tip_before_mm);
  into.tip_after_mm = std::max(into.tip_after_mm, other.tip_after_mm);
  into.tilt_before_rad = std::max(into.tilt_before_rad, other.tilt_before_rad);
  into.tilt_after_rad = std::max(into.tilt_after_rad, other.tilt_after_rad);
}

}  // namespace

void PathTrace::add(const PathStretch& there) {
  if (!stretches_.empty() && stretches_.back().line / width_ == there.line / width_) {
    join(stretches_.back(), there);
    return;
  }
  stretches_.push_back(there);
  while (stretches_.size() > most_) {
    width_ *= 2;
    std::vector<PathStretch> joined;
    for (const PathStretch& stretch : stretches_) {
      if (!joined.empty() && joined.back().line / width_ == stretch.line / width_)
        join(joined.back(), stretch);
      else
        joined.push_back(stretch);
    }
    stretches_ = std::move(joined);
  }
}

}  // namespace trunnion
