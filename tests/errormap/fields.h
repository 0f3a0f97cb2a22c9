#pragma once

#include "errormap/error_surface.h"
#include "support/twin.h"

namespace trunnion {

inline std::vector<Angle> stations_deg(std::initializer_list<double> list) {
  std::vector<Angle> stations;
  for (const double degree : list) stations.push_back(Angle::degrees(degree));
  return stations;
}

/// `field` (indexed position -> RotaryErrors, whose tilt part depends on a only) at the nodes.
template <class Field>
ErrorGrid sampled(Field field, std::vector<Angle> a_stations, std::vector<Angle> c_stations) {
  ErrorGrid grid = zero_grid(std::move(a_stations), std::move(c_stations));
  for (std::size_t i = 0; i < grid.a_stations.size(); ++i) {
    grid.tilt[i] = field(IndexedPosition{grid.a_stations[i], Angle()}).tilt;
    for (std::size_t j = 0; j < grid.c_stations.size(); ++j)
      grid.turn[i * grid.c_stations.size() + j] = field(IndexedPosition{grid.a_stations[i], grid.c_stations[j]}).turn;
  }
  return grid;
}

inline double difference(const RotaryErrors& a, const RotaryErrors& b) {
  return (stacked(a) - stacked(b)).cwiseAbs().maxCoeff();
}

/// Harmonics of c up to two, with coefficients that are cubic in a: what four tilts and six turns determine.
inline RotaryErrors band_limited(IndexedPosition at) {
  const double a = at.a.in_radians(), c = at.c.in_radians();
  const double cubic = 1 - 0.7 * a + 0.4 * a * a + 0.3 * a * a * a;
  RotaryErrors e;
  e.tilt.translation_mm = {0.004 * cubic, -0.003 * a, 0.002};
  e.tilt.rotation_rad = {3e-5 * cubic, 1e-5 * a * a, -2e-5};
  e.turn.translation_mm = {0.005 * std::cos(c) * cubic, 0.003 * std::sin(2 * c), 0.001 * a};
  e.turn.rotation_rad = {2e-5 * std::sin(c), 1e-5 * std::cos(2 * c) * cubic, 4e-5 * a * std::sin(c)};
  return e;
}

}  // namespace trunnion
