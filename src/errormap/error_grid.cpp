#include "errormap/error_grid.h"

#include <utility>

namespace trunnion {

Eigen::VectorXd ErrorGrid::coefficients() const {
  Eigen::VectorXd values(static_cast<Eigen::Index>(coefficient_count()));
  Eigen::Index k = 0;
  for (const auto* part : {&tilt, &turn})
    for (const PoseError& error : *part) values.segment<6>(std::exchange(k, k + 6)) = error.vector();
  return values;
}

ErrorGrid zero_grid(std::vector<Angle> a_stations, std::vector<Angle> c_stations) {
  ErrorGrid grid{.a_stations = std::move(a_stations), .c_stations = std::move(c_stations)};
  grid.tilt.resize(grid.a_stations.size());
  grid.turn.resize(grid.a_stations.size() * grid.c_stations.size());
  return grid;
}

ErrorGrid with_coefficients(const ErrorGrid& grid, const Eigen::VectorXd& coefficients) {
  ErrorGrid result = grid;
  Eigen::Index k = 0;
  for (auto* part : {&result.tilt, &result.turn})
    for (PoseError& error : *part) error = PoseError::from_vector(coefficients.segment<6>(std::exchange(k, k + 6)));
  return result;
}

ErrorGrid split_after_eq1(const ErrorGrid& grid, const KinematicChain& chain) {
  if (!chain.tilt_carries_turn()) return grid;
  ErrorGrid result = grid;
  const std::size_t columns = grid.c_stations.size();
  for (std::size_t i = 0; i < grid.a_stations.size(); ++i) {
    PoseError mean;
    for (std::size_t j = 0; j < columns; ++j) mean += (1.0 / static_cast<double>(columns)) * grid.turn[i * columns + j];
    for (std::size_t j = 0; j < columns; ++j) result.turn[i * columns + j] = grid.turn[i * columns + j] - mean;
    const IndexedPosition at{grid.a_stations[i], Angle()};
    const Eigen::Isometry3d tilt_from_turn = chain.r_from_joint(chain.tilt_index(), at).inverse(Eigen::Isometry) *
                                             chain.r_from_joint(chain.turn_index(), at);
    result.tilt[i] += PoseError::from_vector(adjoint(tilt_from_turn) * mean.vector());
  }
  return result;
}

}  // namespace trunnion
