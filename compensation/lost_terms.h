#pragma once

#include <string>
#include <vector>

#include "compensation/controller.h"

namespace trunnion {

/// An error that a compensation leaves, and the deviation that it makes by itself: root mean square over the volume.
struct LostTerm {
  std::string term;
  double position_rms_mm = 0;
};

/// What of the machine's errors `played` does not take away, as ISO 230 symbols of the two rotary axes, largest first.
/// At each of a grid of (A, C) the deviation left at four tips is told as a twist of the table,
///   d(p) = D + theta x p + rest,
/// its mean over C as an error of A and the remainder as one of C, both in their axis' frame before its motion. What is
/// no twist is called after the linear axes, what changes with the sense of motion after A_dir and C_dir. Terms below a
/// hundredth of the whole are left out; angles and lengths of one axis may make part of each other's deviation good, so
/// that squares do not add up.
std::vector<LostTerm> lost_terms(const CompensationTask& task, const PlayedCompensation& played);

}  // namespace trunnion
