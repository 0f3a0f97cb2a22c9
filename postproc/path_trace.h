#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace trunnion {

/// The largest errors met on a stretch of a program: of the tip, mm, and of the tool axis, rad, before and after.
struct PathStretch {
  std::uint64_t line = 0;  ///< of the original, where the stretch begins
  double tip_before_mm = 0, tip_after_mm = 0;
  double tilt_before_rad = 0, tilt_after_rad = 0;
  friend bool operator==(const PathStretch&, const PathStretch&) = default;
};

/// Errors along a path of any length as at most `most` stretches of equally many lines: those of a short program line
/// by line; when they become too many, neighbours are joined. What was largest stays.
class PathTrace {
 public:
  explicit PathTrace(std::size_t most = 2000) : most_(most) {}
  /// Errors at a place that belongs to `there.line`; lines ascend.
  void add(const PathStretch& there);
  const std::vector<PathStretch>& stretches() const { return stretches_; }
  std::uint64_t lines_per_stretch() const { return width_; }

 private:
  std::size_t most_;
  std::uint64_t width_ = 1;
  std::vector<PathStretch> stretches_;
};

}  // namespace trunnion
