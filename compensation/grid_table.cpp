#include "compensation/grid_table.h"

#include <algorithm>
#include <cmath>

namespace trunnion {
namespace {

/// The cell of `x` and how far into it, ends held.
struct Place {
  std::size_t cell = 0;
  double into = 0;
};

Place place_of(const std::vector<double>& nodes, double x) {
  if (nodes.size() < 2 || !(x > nodes.front())) return {};
  if (x >= nodes.back()) return {nodes.size() - 2, 1};
  const auto cell = static_cast<std::size_t>(std::ranges::upper_bound(nodes, x) - nodes.begin() - 1);
  return {cell, (x - nodes[cell]) / (nodes[cell + 1] - nodes[cell])};
}

}  // namespace

double interpolated(const std::vector<double>& nodes, const std::vector<double>& values, Boundary boundary, double x) {
  if (nodes.size() == 1) return values.front();
  if (boundary == Boundary::repeat) {
    const double period = nodes.back() - nodes.front();
    x -= period * std::floor((x - nodes.front()) / period);
  }
  const Place at = place_of(nodes, x);
  return values[at.cell] + at.into * (values[at.cell + 1] - values[at.cell]);
}

double interpolated(const std::vector<double>& rows, const std::vector<double>& columns, const Eigen::MatrixXd& values,
                    double row, double column) {
  const Place r = place_of(rows, row), c = place_of(columns, column);
  const auto i = static_cast<Eigen::Index>(r.cell), j = static_cast<Eigen::Index>(c.cell);
  const Eigen::Index below = std::min(i + 1, values.rows() - 1), beside = std::min(j + 1, values.cols() - 1);
  return (1 - r.into) * ((1 - c.into) * values(i, j) + c.into * values(i, beside)) +
         r.into * ((1 - c.into) * values(below, j) + c.into * values(below, beside));
}

}  // namespace trunnion
