#pragma once

#include <span>
#include <string>

#include "testpiece/machining.h"

namespace trunnion {

/// The part as a binary glTF 2.0 file (GLB): the flank coloured by its deviation, every vertex by `deviation_colour`,
/// the discs within its first and last circle grey; beside it a colour bar in um that ends at `end_um` (round_scale),
/// which stands in asset.extras.scale_um as well. glTF's metres, Y up: (x, z, -y) of W. `surface` is a grid of heights
/// ascending over even phi, `magnification` moves the vertices that many times their deviation along the normal (0: the
/// nominal shape).
std::string part_glb(const TestPiece& piece, const SurfaceGrid& surface, std::span<const double> deviation_mm,
                     double end_um, double magnification = 0);

}  // namespace trunnion
