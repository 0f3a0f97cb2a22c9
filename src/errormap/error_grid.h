#pragma once

#include <Eigen/Core>
#include <vector>

#include "geometric_errors/rotary_errors.h"

namespace trunnion {

/// The twelve rotary errors at indexed positions (a[i], c[j]): six of the tilting axis per A station, six of C per
/// pair. A plain value; make_surface() checks it. Stored as one vector of coefficients, mm and rad:
///   EXA … ECA at a[0], …, at a[n-1], then EXC … ECC at (a[0], c[0]), (a[0], c[1]), …
struct ErrorGrid {
  std::vector<Angle> a_stations;  ///< strictly ascending
  std::vector<Angle> c_stations;  ///< strictly ascending, spanning less than a turn
  std::vector<PoseError> tilt;    ///< one per A station
  std::vector<PoseError> turn;    ///< `turn[i * c_stations.size() + j]`

  std::size_t tilt_offset(std::size_t i) const { return 6 * i; }
  std::size_t turn_offset(std::size_t i, std::size_t j) const {
    return 6 * (a_stations.size() + i * c_stations.size() + j);
  }
  std::size_t coefficient_count() const { return 6 * a_stations.size() * (1 + c_stations.size()); }
  RotaryErrors at_node(std::size_t i, std::size_t j) const { return {tilt[i], turn[i * c_stations.size() + j]}; }

  Eigen::VectorXd coefficients() const;
  friend bool operator==(const ErrorGrid&, const ErrorGrid&) = default;
};

/// A grid of zeros at the given stations.
ErrorGrid zero_grid(std::vector<Angle> a_stations, std::vector<Angle> c_stations);

/// `grid` with the coefficients replaced.
ErrorGrid with_coefficients(const ErrorGrid& grid, const Eigen::VectorXd& coefficients);

/// The same pose errors with C's six averaging to zero over the C stations at each A (Eq. 1): the mean goes to the
/// tilting axis, turned by its nominal motion; exact to first order. Only where the tilting axis carries C, as on a
/// trunnion: elsewhere (C carries the tilting axis, or they stand on different sides of the bed) a constant of C is no
/// error of the tilting axis, and the grid comes back as it is.
ErrorGrid split_after_eq1(const ErrorGrid& grid, const KinematicChain& chain);

}  // namespace trunnion
