#include "errormap/cross_validation.h"

#include <cmath>

namespace trunnion {
namespace {

/// `grid` without row `i` or column `j`; one that it has not stays without effect.
ErrorGrid without(const ErrorGrid& grid, std::size_t row, std::size_t column) {
  ErrorGrid rest;
  for (std::size_t j = 0; j < grid.c_stations.size(); ++j)
    if (j != column) rest.c_stations.push_back(grid.c_stations[j]);
  for (std::size_t i = 0; i < grid.a_stations.size(); ++i) {
    if (i == row) continue;
    rest.a_stations.push_back(grid.a_stations[i]);
    rest.tilt.push_back(grid.tilt[i]);
    for (std::size_t j = 0; j < grid.c_stations.size(); ++j)
      if (j != column) rest.turn.push_back(grid.at_node(i, j).turn);
  }
  return rest;
}

struct Sum {
  double mm2 = 0, rad2 = 0;
  std::size_t nodes = 0;
  void take(const KinematicChain& chain, IndexedPosition at, const RotaryErrors& miss) {
    Eigen::Matrix<double, 12, 1> errors;
    errors << miss.tilt.vector(), miss.turn.vector();
    const Vector6d e = relative_error_jacobian(chain, at, {}).here * errors;
    mm2 += e.head<3>().squaredNorm(), rad2 += e.tail<3>().squaredNorm(), ++nodes;
  }
  Misses misses() const {
    if (nodes == 0) return {};
    const auto n = static_cast<double>(nodes);
    return {Length::millimetres(std::sqrt(mm2 / n)), Angle::radians(std::sqrt(rad2 / n)), nodes};
  }
};

}  // namespace

CrossValidation cross_validate(Interpolation method, const ErrorGrid& grid, const KinematicChain& chain) {
  const std::size_t rows = grid.a_stations.size(), columns = grid.c_stations.size();
  Sum of_columns, of_rows;
  for (std::size_t j = 0; columns >= 3 && j < columns; ++j) {
    const auto surface = make_surface(method, without(grid, rows, j));
    for (std::size_t i = 0; i < rows; ++i) {
      const IndexedPosition at{grid.a_stations[i], grid.c_stations[j]};
      of_columns.take(chain, at, surface->at(at) - grid.at_node(i, j));
    }
  }
  for (std::size_t i = 1; i + 1 < rows; ++i) {
    const auto surface = make_surface(method, without(grid, i, columns));
    for (std::size_t j = 0; j < columns; ++j) {
      const IndexedPosition at{grid.a_stations[i], grid.c_stations[j]};
      of_rows.take(chain, at, surface->at(at) - grid.at_node(i, j));
    }
  }
  const Sum both{of_columns.mm2 + of_rows.mm2, of_columns.rad2 + of_rows.rad2, of_columns.nodes + of_rows.nodes};
  return {of_columns.misses(), of_rows.misses(), both.misses()};
}

}  // namespace trunnion
