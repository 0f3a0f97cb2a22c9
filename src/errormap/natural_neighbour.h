#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "units/angle.h"

namespace trunnion {

/// Weights of Sibson's C1 natural-neighbour interpolant on the nodes of a grid, periodic in C:
///
///   f(x) = (alpha Z + beta xi) / (alpha + beta),   Z = sum l_i f_i,
///   xi = sum (l_i / r_i) (f_i + g_i . (x - x_i)) / sum (l_i / r_i),
///   alpha = sum l_i r_i / sum (l_i / r_i),   beta = sum l_i r_i^2,   r_i = |x - x_i|,
///
/// with the natural-neighbour coordinates l_i of x (Sibson, A brief description of natural neighbour interpolation,
/// 1981). The slope g_i at a node is fitted to its own natural neighbours, weight l / r^2. Both are linear in the
/// values, so the whole is: f = w(x) . f with w of this class. The grid is repeated at -2 pi and 2 pi in C; beyond both
/// ends of A stand rows that carry on in a straight line, so that the end stations have slopes too.
class NaturalNeighbour {
 public:
  NaturalNeighbour(const std::vector<Angle>& a_stations, const std::vector<Angle>& c_stations);
  ~NaturalNeighbour();
  NaturalNeighbour(NaturalNeighbour&&) noexcept;
  NaturalNeighbour& operator=(NaturalNeighbour&&) noexcept;

  /// One weight per node (a[i], c[j]), at i * c_stations.size() + j. A tilt outside the stations is taken as the
  /// nearest station. Not for two threads at once on one object.
  Eigen::VectorXd weights(Angle a, Angle c) const;

 private:
  struct Triangulation;
  std::unique_ptr<Triangulation> triangulation_;
};

}  // namespace trunnion
