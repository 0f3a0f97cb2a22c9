#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "testpiece/cone_evaluation.h"

namespace trunnion {

/// The nominal cone, displaced as a rigid body and grown alike all over until it fits a measured flank best (least
/// squares along the normal). In the cone's own frame, with t the half angle, r(h) the radius,
///   deviation(phi, h) = size + cos t (x cos phi + y sin phi)
///                       + (h cos t - r(h) sin t) (beta cos phi - alpha sin phi) + residual.
/// A turn about the axis shows nowhere, a shift along it is a size on a cone; what one height alone cannot tell apart
/// is told by translations.
struct FlankFit {
  Eigen::Vector2d shift_mm = Eigen::Vector2d::Zero();  ///< x, y: of the axis at the base
  Eigen::Vector2d tilt_rad = Eigen::Vector2d::Zero();  ///< alpha, beta: turns about x and y
  double size_mm = 0;                                  ///< along the normal
  std::vector<std::vector<double>> residual_mm;        ///< one per trace and point
  double rms_mm = 0;                                   ///< of the residual
  double form_mm = 0;                                  ///< largest less smallest residual
};
FlankFit fit_flank(std::span<const ConeTrace> traces, Angle half_angle);

}  // namespace trunnion
