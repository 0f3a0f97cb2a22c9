#pragma once

#include <memory>

#include "compensation/axis_correction.h"
#include "compensation/working_volume.h"

// What a table format could do at best: least squares over poses, unrounded, on dense piecewise linear functions in the
// format's products, every unknown at once. Shares nothing with the emitters and their projections.

namespace trunnion::compensation_test {

/// Which products of functions a control adds up.
struct Format {
  bool pairs = false;       ///< X, Y, Z, A and C each by a function of (A, C)
  bool levers = false;      ///< X, Y, Z in proportion to x, y, z, by functions of A and of C
  bool own_axes = false;    ///< A by a function of A, C by one of C
  bool chain = false;       ///< X, Y, Z follow errors of A over A and of C over C, in the frames of the axes
  bool places = false;      ///< X, Y, Z follow the axes to other places
  bool directions = false;  ///< … and other directions
};

/// The corrections of `format` for which the mean over the volume of |deviation|^2 + (20 mm x tilt of the tool)^2 is
/// least, with nodes every `spacing_deg`. Machines with both rotary axes under the work, C on the tilting one.
std::unique_ptr<PlayedCompensation> best_of(const Format& format, const Machine& machine, const Model& model,
                                            const WorkingVolume& volume, double spacing_deg);

}  // namespace trunnion::compensation_test
