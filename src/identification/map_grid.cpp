#include "identification/map_grid.h"

#include <algorithm>
#include <cmath>

#include "errormap/pose_split.h"

namespace trunnion {
namespace {

/// Cluster centres of `values` (deg), those closer than 0.1 deg being one; `period` 0 for none.
std::vector<double> stations_of(std::vector<double> values) {
  std::ranges::sort(values);
  std::vector<double> centres;
  for (std::size_t i = 0; i < values.size();) {
    std::size_t j = i;
    double sum = 0;
    while (j < values.size() && values[j] - values[i] <= 0.2) sum += values[j++];
    centres.push_back(sum / static_cast<double>(j - i));
    i = j;
  }
  return centres;
}

std::ptrdiff_t nearest(const std::vector<double>& stations, double value, double period) {
  for (std::size_t k = 0; k < stations.size(); ++k) {
    double gap = value - stations[k];
    if (period > 0) gap = std::remainder(gap, period);
    if (std::abs(gap) <= 0.15) return static_cast<std::ptrdiff_t>(k);
  }
  return -1;
}

/// Rounds a station to a whole thousandth of a degree where it is within a tenth of that: what was commanded.
Angle station(double degrees) {
  const double whole = std::round(degrees * 1000) / 1000;
  return Angle::degrees(std::abs(degrees - whole) < 1e-4 ? whole : degrees);
}

/// The nodes of a grid by tilt, those marked in `incomplete` left out of the mean.
std::vector<std::vector<SplitNode>> split_rows(const PoseGrid& grid, const std::vector<bool>& incomplete) {
  std::vector<std::vector<SplitNode>> rows(grid.a_stations.size());
  for (std::size_t k = 0; k < grid.pose_at.size(); ++k) {
    const std::size_t i = k / grid.c_stations.size(), j = k % grid.c_stations.size();
    rows[i].push_back({{grid.a_stations[i], grid.c_stations[j]}, incomplete.empty() || !incomplete[k]});
  }
  return rows;
}

}  // namespace

std::size_t PoseGrid::missing() const { return static_cast<std::size_t>(std::ranges::count(pose_at, -1)); }

PoseGrid find_grid(const std::vector<PoseGroup>& all) {
  // Stretches of a path are no stations, unless there is nothing else; they come last.
  std::vector<PoseGroup> poses;
  for (const PoseGroup& pose : all)
    if (!pose.moving || all.front().moving) poses.push_back(pose);
  std::vector<double> a, c;
  for (const PoseGroup& pose : poses) {
    a.push_back(pose.at.a.in_degrees());
    const double turned = pose.at.c.in_degrees() - 360 * std::floor(pose.at.c.in_degrees() / 360);
    c.push_back(turned > 359.85 ? turned - 360 : turned);
  }
  std::vector<double> a_stations = stations_of(a), c_stations = stations_of(c);
  const auto keep_common = [](std::vector<double>& stations, const std::vector<double>& values, double period) {
    std::vector<std::size_t> counts(stations.size(), 0);
    for (const double value : values)
      if (const auto k = nearest(stations, value, period); k >= 0) ++counts[static_cast<std::size_t>(k)];
    const std::size_t most = counts.empty() ? 0 : *std::ranges::max_element(counts);
    std::vector<double> kept;
    for (std::size_t k = 0; k < stations.size(); ++k)
      if (2 * counts[k] >= most) kept.push_back(stations[k]);
    stations = kept;
  };
  keep_common(a_stations, a, 0);
  keep_common(c_stations, c, 360);
  PoseGrid grid;
  const auto place = [&] {
    grid.pose_at.assign(a_stations.size() * c_stations.size(), -1);
    grid.off_grid.clear();
    for (std::size_t p = 0; p < poses.size(); ++p) {
      const auto i = nearest(a_stations, a[p], 0), j = nearest(c_stations, c[p], 360);
      if (i < 0 || j < 0)
        grid.off_grid.push_back(p);
      else
        grid.pose_at[static_cast<std::size_t>(i) * c_stations.size() + static_cast<std::size_t>(j)] =
            static_cast<std::ptrdiff_t>(p);
    }
  };
  place();
  const bool reaches_zero = !a_stations.empty() && a_stations.front() <= 1e-9 && a_stations.back() >= -1e-9;
  if (!reaches_zero || 2 * grid.missing() > grid.pose_at.size()) {  // scattered: a grid of its own
    const double low = std::min(0.0, *std::ranges::min_element(a)), high = std::max(0.0, *std::ranges::max_element(a));
    const int steps = std::max(1, static_cast<int>(std::ceil((high - low) / 15)));
    a_stations.clear();
    for (int i = 0; i <= steps; ++i) a_stations.push_back(low + (high - low) * i / steps);
    c_stations.clear();
    for (int j = 0; j < 12; ++j) c_stations.push_back(30.0 * j);
    place();
  }
  for (const double value : a_stations) grid.a_stations.push_back(station(value));
  for (const double value : c_stations) grid.c_stations.push_back(station(value));
  return grid;
}

RotaryMapContent map_from_surface(const LinearProblem& problem, const PoseGrid& grid, const SmoothFit& smooth) {
  // theta -> the twelve errors at the nodes, C's mean moved to the tilting axis: one linear operator.
  RotaryMapContent content;
  content.grid = zero_grid(grid.a_stations, grid.c_stations);
  const HarmonicSurface surface(smooth.basis, smooth.coefficients);
  const Eigen::Index m = smooth.coefficients.size();
  Eigen::MatrixXd map = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(content.grid.coefficient_count()), m);
  const std::size_t columns = grid.c_stations.size();
  if (problem.chain->has_rotary(Side::workpiece) && !problem.chain->has_rotary(Side::tool)) {
    Eigen::MatrixXd delta(6 * static_cast<Eigen::Index>(grid.pose_at.size()), m);
    for (std::size_t k = 0; k < grid.pose_at.size(); ++k) {
      Situation s;
      s.at = {grid.a_stations[k / columns], grid.c_stations[k % columns]};
      delta.middleRows<6>(6 * static_cast<Eigen::Index>(k)) = gauged_basis(*problem.chain, smooth.basis, s);
    }
    const PoseSplit split = split_pose_errors(*problem.chain, split_rows(grid, {}));
    map << split.tilt * delta, split.turn * delta;
  } else {
    for (std::size_t k = 0; k < grid.pose_at.size(); ++k) {
      const std::size_t i = k / columns, j = k % columns;
      const auto b = surface.jacobian({grid.a_stations[i], grid.c_stations[j]});
      map.middleRows<6>(static_cast<Eigen::Index>(content.grid.turn_offset(i, j))) = b.bottomRows(6);
      map.middleRows<6>(static_cast<Eigen::Index>(content.grid.tilt_offset(i))) = b.topRows(6);
    }
  }
  content.grid = with_coefficients(content.grid, map * smooth.coefficients);
  content.grid_covariance = map * smooth.covariance * map.transpose();
  content.full_covariance = true;
  return content;
}

void set_smooth_surface(RotaryMapContent& content, const LinearProblem& problem, const SmoothFit& smooth) {
  SmoothFit kept = without_unseen_constants(smooth, *problem.chain);
  content.smooth_basis = kept.basis;
  content.smooth_method = "gaussian-process";
  content.smooth_coefficients = std::move(kept.coefficients);
  content.smooth_covariance = std::move(kept.covariance);
}

RotaryMapContent map_from_poses(const LinearProblem& problem, const PoseGrid& grid, const FreePoseFit& fit,
                                const SmoothFit& smooth) {
  RotaryMapContent content;
  content.grid = zero_grid(grid.a_stations, grid.c_stations);
  const auto n = static_cast<Eigen::Index>(content.grid.coefficient_count());
  const std::size_t columns = grid.c_stations.size();
  // Stack the deltas of the fit, and after them those that the smooth map gives at nodes that were not probed.
  std::vector<Eigen::Index> column_of(grid.pose_at.size(), -1);
  Eigen::Index stacked = fit.covariance.rows();
  for (std::size_t k = 0; k < grid.pose_at.size(); ++k) {
    if (grid.pose_at[k] >= 0)
      column_of[k] = fit.column[static_cast<std::size_t>(grid.pose_at[k])];
    else
      column_of[k] = stacked, stacked += 6;
  }
  Eigen::VectorXd delta = Eigen::VectorXd::Zero(stacked);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(stacked, stacked);
  covariance.topLeftCorner(fit.covariance.rows(), fit.covariance.rows()) = fit.covariance;
  for (std::size_t p = 0; p < fit.delta.size(); ++p)
    if (fit.column[p] >= 0) delta.segment<6>(fit.column[p]) = fit.delta[p].vector();
  std::vector<bool> incomplete(grid.pose_at.size(), false);
  std::vector<std::vector<bool>> reached(grid.pose_at.size(), std::vector<bool>(6, false));
  for (std::size_t k = 0; k < grid.pose_at.size(); ++k) {
    Situation s;
    s.at = {grid.a_stations[k / columns], grid.c_stations[k % columns]};
    if (grid.pose_at[k] < 0) {
      const Matrix6Xd b = gauged_basis(*problem.chain, smooth.basis, s);
      delta.segment<6>(column_of[k]) = b * smooth.coefficients;
      covariance.block<6, 6>(column_of[k], column_of[k]) = b * smooth.covariance * b.transpose();
      continue;
    }
    for (const UnseenFreedom& freedom : fit.unseen)
      if (static_cast<std::ptrdiff_t>(freedom.pose) == grid.pose_at[k]) {
        incomplete[k] = true;
        // As C's errors see it: the direction in C's frame.
        Vector6d direction = freedom.direction;
        direction.tail<3>() /= 100;
        const Vector6d in_turn = turn_from_pose(*problem.chain, s.at) * direction;
        for (Eigen::Index c = 0; c < 6; ++c)
          if (std::abs(in_turn[c]) * (c < 3 ? 1 : 100) > 1e-3) reached[k][static_cast<std::size_t>(c)] = true;
      }
  }
  const PoseSplit split = split_pose_errors(*problem.chain, split_rows(grid, incomplete));
  Eigen::MatrixXd map = Eigen::MatrixXd::Zero(n, stacked);
  for (std::size_t k = 0; k < column_of.size(); ++k)
    if (column_of[k] >= 0)
      map.middleCols<6>(column_of[k]) << split.tilt.middleCols<6>(6 * static_cast<Eigen::Index>(k)),
          split.turn.middleCols<6>(6 * static_cast<Eigen::Index>(k));
  content.unseen.assign(static_cast<std::size_t>(n), false);
  for (std::size_t k = 0; k < reached.size(); ++k) {
    const std::size_t i = k / columns, j = k % columns;
    for (std::size_t c = 0; c < 6; ++c) {
      if (!split.told[i]) content.unseen[content.grid.tilt_offset(i) + c] = true;
      if (!split.told[i] || reached[k][c]) content.unseen[content.grid.turn_offset(i, j) + c] = true;
    }
  }
  if (std::ranges::none_of(content.unseen, [](bool b) { return b; })) content.unseen.clear();
  Eigen::VectorXd values = map * delta;
  for (std::size_t k = 0; k < content.unseen.size(); ++k)
    if (content.unseen[k]) values[static_cast<Eigen::Index>(k)] = 0;
  content.grid = with_coefficients(content.grid, values);
  content.grid_covariance = map * covariance * map.transpose();
  content.full_covariance = true;
  return content;
}

}  // namespace trunnion
