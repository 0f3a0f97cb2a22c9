#include "testpiece/cone_evaluation.h"

#include <algorithm>
#include <cmath>

#include "error.h"
#include "testpiece/flank_fit.h"
#include "testpiece/profile_filter.h"

namespace trunnion {
namespace {

/// Slope of the least squares line of `y` over `x`.
template <class Value>
Value slope(const std::vector<double>& x, const std::vector<Value>& y, Value zero) {
  double mean = 0, squares = 0;
  for (const double v : x) mean += v / static_cast<double>(x.size());
  Value sum = zero;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sum += (x[i] - mean) * y[i];
    squares += (x[i] - mean) * (x[i] - mean);
  }
  return sum / squares;
}

}  // namespace

RoundnessTrace radial_trace(const ConeTrace& trace, Angle half_angle, const EvaluationOptions& options) {
  RoundnessTrace radial{trace.nominal_radius_mm, trace.phi_rad, trace.normal_mm};
  for (double& r : radial.radial_mm) r /= std::cos(half_angle.in_radians());
  return options.filter_upr ? gaussian_filtered(radial, *options.filter_upr) : radial;
}

ConeEvaluation evaluate_cone(std::span<const ConeTrace> traces, Angle nominal_half_angle,
                             const EvaluationOptions& options) {
  if (traces.empty()) throw InputError("no trace of the cone to evaluate");
  ConeEvaluation result;
  double squares = 0;
  std::size_t count = 0;
  std::vector<ConeTrace> evaluated(traces.begin(), traces.end());
  for (ConeTrace& trace : evaluated) {
    const RoundnessTrace radial = radial_trace(trace, nominal_half_angle, options);
    if (options.filter_upr)
      for (std::size_t i = 0; i < radial.radial_mm.size(); ++i)
        trace.normal_mm[i] = std::cos(nominal_half_angle.in_radians()) * radial.radial_mm[i];
    const ReferenceCircle lsc = least_squares_circle(radial);
    result.heights.push_back({.h_mm = trace.h_mm,
                              .lsc_mm = lsc.roundness_mm,
                              .mzc_mm = minimum_zone_circle(radial).roundness_mm,
                              .mic_mm = maximum_inscribed_circle(radial).roundness_mm,
                              .mcc_mm = minimum_circumscribed_circle(radial).roundness_mm,
                              .center_mm = lsc.center_mm,
                              .diameter_mm = 2 * (trace.nominal_radius_mm + lsc.size_mm)});
    for (const double v : trace.normal_mm) squares += v * v;
    count += trace.normal_mm.size();
  }
  result.rms_mm = std::sqrt(squares / static_cast<double>(count));
  result.form_mm = fit_flank(evaluated, nominal_half_angle).form_mm;

  std::vector<double> h, radius;
  std::vector<Eigen::Vector2d> centers;
  for (const HeightEvaluation& at : result.heights) {
    h.push_back(at.h_mm);
    radius.push_back(at.diameter_mm / 2);
    centers.push_back(at.center_mm);
  }
  const auto [low, high] = std::ranges::minmax_element(h);
  if (*high - *low < 1e-9) return result;
  result.half_angle = Angle::radians(std::atan(-slope(h, radius, 0.0)));
  result.axis_tilt_rad = slope(h, centers, Eigen::Vector2d(0, 0));
  double apart = 0;
  for (const Eigen::Vector2d& a : centers)
    for (const Eigen::Vector2d& b : centers) apart = std::max(apart, (a - b).norm());
  result.concentricity_mm = apart;
  result.conicity_mm =
      2 * (radius[static_cast<std::size_t>(low - h.begin())] - radius[static_cast<std::size_t>(high - h.begin())] -
           (*high - *low) * std::tan(nominal_half_angle.in_radians()));
  return result;
}

}  // namespace trunnion
