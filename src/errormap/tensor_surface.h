#pragma once

#include <functional>

#include "errormap/error_surface.h"

namespace trunnion {

/// Weights of the stations of one axis at a coordinate.
using StationWeights = std::function<Eigen::VectorXd(double)>;

/// A surface on a grid whose weights are products: E(a, c) = sum_ij wa_i(a) wc_j(c) E[i, j].
class TensorSurface : public ErrorSurface {
 public:
  TensorSurface(ErrorGrid grid, StationWeights a_weights, StationWeights c_weights);

  RotaryErrors at(IndexedPosition position) const override;
  Eigen::Matrix<double, 12, Eigen::Dynamic> jacobian(IndexedPosition position) const override;
  Eigen::Index coefficient_count() const override { return static_cast<Eigen::Index>(grid_.coefficient_count()); }
  Range<Angle> a_range() const override { return {grid_.a_stations.front(), grid_.a_stations.back()}; }

 private:
  ErrorGrid grid_;
  Eigen::Matrix<double, 6, Eigen::Dynamic> tilt_, turn_;
  StationWeights a_weights_, c_weights_;
};

/// Cubic spline weights over `stations` (rad): not-a-knot from four stations, natural for three, a line for two.
StationWeights cubic_weights(const std::vector<Angle>& stations);
/// Piecewise linear weights; beyond the ends the last piece goes on.
StationWeights linear_weights(const std::vector<Angle>& stations);
/// Trigonometric interpolation weights, 2 pi-periodic.
StationWeights trigonometric_weights(const std::vector<Angle>& stations);
/// Piecewise linear and 2 pi-periodic.
StationWeights periodic_linear_weights(const std::vector<Angle>& stations);

}  // namespace trunnion
