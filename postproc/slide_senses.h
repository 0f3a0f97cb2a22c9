#pragma once

#include "postproc/motion.h"

namespace trunnion {

/// In which sense the slides X, Y, Z moved last, as a program goes on: under tool-centre-point control that depends on
/// all axes. To and fro of less than a micrometre is rounding, no reversal.
class SlideSenses {
 public:
  /// `chain` must outlive it; the tool's length matters where the head carries a rotary axis.
  SlideSenses(const KinematicChain& chain, double tool_length_mm) : chain_(&chain), tool_length_mm_(tool_length_mm) {}

  /// Fills block.linear_sense, at the block's end; 0 for a slide that has not moved since all axes were known. And
  /// block.turns_round, the slides that turn round on the way.
  void follow(MotionBlock& block);

 private:
  Eigen::Vector3d slides_mm(const MotionBlock& block, const AxisValues& at) const;

  const KinematicChain* chain_;
  double tool_length_mm_;
  Eigen::Vector3d from_mm_ = Eigen::Vector3d::Zero();  // where each slide turned about, or was last
  std::array<std::int8_t, 3> sense_{};
};

/// How long a block at feed lasts, s; 0 where that is not known, and for rapids.
double block_seconds(const MotionBlock& block);

}  // namespace trunnion
