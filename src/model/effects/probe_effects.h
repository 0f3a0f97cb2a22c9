#pragma once

#include "model/catalogue.h"

namespace trunnion {

/// Whether a touch-trigger probe is at work in this situation, the only case in which it can err.
inline bool touching(const Situation& s) { return s.reading == ReadingKind::contact; }

/// A reading that is too large by 1 along the approach: D = n, so that n . D = 1.
inline Matrix6Xd along_approach(const Situation& s, double factor) {
  Matrix6Xd b = Matrix6Xd::Zero(6, 1);
  if (touching(s)) b.topRows<3>() = factor * s.approach_r;
  return b;
}

}  // namespace trunnion
