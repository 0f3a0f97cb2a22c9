#pragma once

#include "errormap/error_surface.h"

namespace trunnion {

/// How far an interpolant misses nodes that it was not shown: root mean square of |D| and of |theta| of the absolute
/// pose error e = Ad eA + Ad eC at R's origin, over `nodes` of them; none where nothing could be left out.
struct Misses {
  Length displacement;
  Angle rotation;
  std::size_t nodes = 0;
};

/// The misses of one way of interpolating.
struct CrossValidation {
  Misses columns;  ///< each C station left out whole; needs three or more
  Misses rows;     ///< each A station between the ends left out whole
  Misses all;
};

/// Leave one angle out: a whole C column or interior A row, since its neighbours in the row would give a single node
/// away. Tells too much where the field has as many harmonics as the remaining angles carry: an upper bound.
CrossValidation cross_validate(Interpolation method, const ErrorGrid& grid, const KinematicChain& chain);

}  // namespace trunnion
