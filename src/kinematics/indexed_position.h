#pragma once

#include "units/angle.h"

namespace trunnion {

/// Where the two rotary axes are commanded to stand: `a` the tilting axis (A, or B on a machine that has B), `c` the
/// turning axis, both as commanded, C unwrapped or not.
struct IndexedPosition {
  Angle a;
  Angle c;
  friend bool operator==(const IndexedPosition&, const IndexedPosition&) = default;
};

}  // namespace trunnion
