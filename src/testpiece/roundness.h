#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace trunnion {

/// A closed trace in one plane: where the surface stands beyond (+) or within (-) a nominal circle, in the order of
/// phi or not. Throws where used: InputError unless it has four points or more, no gap of half a turn, and none
/// at or beyond the nominal centre.
struct RoundnessTrace {
  double nominal_radius_mm = 0;
  std::vector<double> phi_rad;
  std::vector<double> radial_mm;  ///< radial deviation from the nominal circle, one per phi
};

/// A reference circle of ISO 12181 and the roundness deviation about it.
struct ReferenceCircle {
  Eigen::Vector2d center_mm = Eigen::Vector2d::Zero();  ///< from the nominal centre; x along phi = 0
  double size_mm = 0;                                   ///< its radius minus the nominal radius
  double roundness_mm = 0;                              ///< largest minus smallest distance from its centre
};

/// The four reference circles, exact: distances from the centre are true distances, not those of the limacon, and the
/// three extremal ones are optimal to rounding. With r_i the distance of point i from the centre:
///   LSC  minimises sum (r_i - r)^2,          MZC  minimises max r_i - min r_i  (its size: the mean of both),
///   MIC  maximises min r_i,                  MCC  minimises max r_i.
/// Each step solves the problem made linear about the last centre; for the extremal circles that is a linear programme
/// in (u, l, x, y), solved through its dual by a simplex of four columns.
ReferenceCircle least_squares_circle(const RoundnessTrace& trace);
ReferenceCircle minimum_zone_circle(const RoundnessTrace& trace);
ReferenceCircle maximum_inscribed_circle(const RoundnessTrace& trace);
ReferenceCircle minimum_circumscribed_circle(const RoundnessTrace& trace);

/// Largest minus smallest distance of the trace from a centre.
double roundness_about_mm(const RoundnessTrace& trace, const Eigen::Vector2d& center_mm);

}  // namespace trunnion
