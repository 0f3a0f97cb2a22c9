#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "units/angle.h"
#include "units/length.h"

namespace trunnion {

/// A cone frustum on the table, its base down. The cone's axis leans by `tilt` against W's Z towards `tilt_azimuth`.
struct ConeFrustum {
  Angle half_angle;  ///< 0 (a cylinder) to less than 90 deg; it narrows away from the base
  Length base_diameter;
  Length height;  ///< along the axis
  Eigen::Vector3d base_center_w_mm = Eigen::Vector3d::Zero();
  Angle tilt;
  Angle tilt_azimuth;
};

/// Cylinder, bull-nose (corner radius) or ball (corner radius = half the diameter), cutting with its flank.
struct FlankTool {
  Length diameter;
  Length overhang;  ///< how far the tip stands below the base, along the ruling
  Length corner_radius;
  Length length;  ///< from the spindle's gauge line to the tip; matters where the tool carries rotary axes
};

/// The test piece of CONTRACT.md: what is cut, with what, which way round, and where it is evaluated.
struct TestPiece {
  ConeFrustum cone;
  FlankTool tool;
  int sense = 1;                          ///< +1: phi grows while cutting
  std::optional<double> feed_mm_per_min;  ///< of the tip on the workpiece; empty: time stands still
  std::vector<Length> heights;            ///< along the axis from the base
  int points = 360;                       ///< evenly over phi, from 0
};

/// The cone's own frame: origin in the base's centre, z along the cone's axis, x (phi = 0) along the part of W's +X
/// that is square to it. Throws ModelError where the axis lies along W's X, which leaves phi without a zero.
Eigen::Isometry3d w_from_cone(const ConeFrustum& cone);

/// Radius of the nominal cone at height `h`.
Length radius_at(const ConeFrustum& cone, Length h);

/// With K = w_from_cone, t the half angle, r(f) = K (cos f, sin f, 0) and a = K z:
struct ConePoint {
  Eigen::Vector3d point_w_mm;  ///< base centre + r(f) (D/2 - h tan t) + a h
  Eigen::Vector3d normal_w;    ///< outward, r(f) cos t + a sin t
  Eigen::Vector3d ruling_w;    ///< along the flank, away from the base: a cos t - r(f) sin t
};
ConePoint cone_point(const ConeFrustum& cone, const Eigen::Isometry3d& w_from_cone, Angle phi, Length h);

}  // namespace trunnion
