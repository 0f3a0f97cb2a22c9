#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "testpiece/roundness.h"
#include "units/angle.h"

namespace trunnion {

/// One trace of a cone: the deviation along the outward normal of the nominal cone, all round at one height.
struct ConeTrace {
  double h_mm = 0;                ///< along the cone's axis from its base
  double nominal_radius_mm = 0;   ///< of the nominal cone at this height
  std::vector<double> phi_rad;    ///< about the cone's axis
  std::vector<double> normal_mm;  ///< positive: excess material
};

/// What is done to traces before they are evaluated.
struct EvaluationOptions {
  std::optional<double> filter_upr;  ///< Gaussian cutoff before the circles are fitted
};

/// In the plane square to the axis a deviation along the normal is seen as normal / cos(half angle); filtered if asked
/// for: what the circles are fitted to.
RoundnessTrace radial_trace(const ConeTrace& trace, Angle half_angle, const EvaluationOptions& options = {});

/// What was found at one height.
struct HeightEvaluation {
  double h_mm = 0;
  double lsc_mm = 0, mzc_mm = 0, mic_mm = 0, mcc_mm = 0;  ///< roundness deviations
  Eigen::Vector2d center_mm = Eigen::Vector2d::Zero();    ///< of the least squares circle, from the nominal axis
  double diameter_mm = 0;                                 ///< of the least squares circle
};

/// What a cone shows over its heights. What needs two heights is empty where there is one.
struct ConeEvaluation {
  std::vector<HeightEvaluation> heights;
  std::optional<Angle> half_angle;               ///< least squares line through the radii
  std::optional<Eigen::Vector2d> axis_tilt_rad;  ///< slope of the centres over h: towards phi = 0 and phi = 90 deg
  std::optional<double> concentricity_mm;        ///< largest distance between two centres
  std::optional<double> conicity_mm;             ///< diameter at the lowest less at the highest height, less nominal
  double form_mm = 0;  ///< largest less smallest deviation from the best fitting cone (fit_flank)
  double rms_mm = 0;   ///< of all deviations along the normal
};

/// Throws InputError for no trace at all, or a trace that RoundnessTrace does not allow.
ConeEvaluation evaluate_cone(std::span<const ConeTrace> traces, Angle nominal_half_angle,
                             const EvaluationOptions& options = {});

}  // namespace trunnion
