#pragma once

#include "testpiece/mesh.h"

namespace trunnion {

/// A colour bar that stands upright beside a part and faces W's -Y, with its ends and middle written in um, drawn by
/// strokes, and the magnification below it ("x 1000") where there is one. `foot_w_mm`: the lower left corner.
Mesh colour_bar(double end_um, double magnification, const Eigen::Vector3d& foot_w_mm, double height_mm);

/// Letters as strokes on a grid two wide and four high, in the order drawn: what colour_bar can write. Empty for a
/// letter that it has not.
struct Stroke {
  double x1, y1, x2, y2;
};
std::vector<Stroke> strokes_of(char letter);

}  // namespace trunnion
