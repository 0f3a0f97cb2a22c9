#include "errormap/natural_neighbour.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/natural_neighbor_coordinates_2.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "units/angle.h"

namespace trunnion {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::size_t, Kernel>;
using Delaunay = CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<VertexBase>>;
using Point = Kernel::Point_2;
using Coordinates = std::vector<std::pair<Delaunay::Vertex_handle, double>>;

struct TakeHandle {
  using result_type = std::pair<Delaunay::Vertex_handle, double>;
  template <class Pair>
  result_type operator()(const Pair& p) const {
    return {p.first, p.second};
  }
};

}  // namespace

struct NaturalNeighbour::Triangulation {
  /// A row of the triangulation as rows of the grid: `near` of one, `far` of the next further in.
  struct Row {
    double a;
    std::size_t near_row, far_row;
    double near_weight, far_weight;
  };
  /// One vertex: a node of a row, in one of the three turns.
  struct Site {
    std::size_t row, column;
    bool slopes = false;
    Eigen::MatrixXd slope;  ///< 2 x nodes, of the slope by the values of the grid
  };

  std::vector<double> c;
  double a_low = 0, a_high = 0;
  std::vector<Row> rows;
  std::vector<Site> sites;
  Delaunay delaunay;

  Eigen::Index nodes() const {
    std::size_t grid_rows = 0;
    for (const Row& row : rows) grid_rows = std::max(grid_rows, row.near_row + 1);
    return static_cast<Eigen::Index>(grid_rows * c.size());
  }
  /// Adds `weight` times the value of a site.
  void add_value(const Site& site, double weight, Eigen::VectorXd& to) const {
    const Row& row = rows[site.row];
    to[static_cast<Eigen::Index>(row.near_row * c.size() + site.column)] += weight * row.near_weight;
    to[static_cast<Eigen::Index>(row.far_row * c.size() + site.column)] += weight * row.far_weight;
  }
  void fit_slope(Delaunay::Vertex_handle vertex);
};

void NaturalNeighbour::Triangulation::fit_slope(Delaunay::Vertex_handle vertex) {
  Coordinates around;
  if (!CGAL::natural_neighbor_coordinates_2(delaunay, vertex, std::back_inserter(around), TakeHandle()).third) return;
  Site& site = sites[vertex->info()];
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(2, nodes());
  for (const auto& [other, coordinate] : around) {
    const Eigen::Vector2d step(other->point().x() - vertex->point().x(), other->point().y() - vertex->point().y());
    const double weight = coordinate / step.squaredNorm();
    Eigen::VectorXd difference = Eigen::VectorXd::Zero(nodes());
    add_value(sites[other->info()], 1, difference);
    add_value(site, -1, difference);
    normal += weight * step * step.transpose();
    right += weight * step * difference.transpose();
  }
  site.slope = normal.inverse() * right;
  site.slopes = true;
}

NaturalNeighbour::NaturalNeighbour(const std::vector<Angle>& a_stations, const std::vector<Angle>& c_stations)
    : triangulation_(std::make_unique<Triangulation>()) {
  Triangulation& t = *triangulation_;
  for (const Angle station : c_stations) t.c.push_back(station.in_radians());
  double widest = t.c.front() + kTurn_rad - t.c.back();
  for (std::size_t j = 1; j < t.c.size(); ++j) widest = std::max(widest, t.c[j] - t.c[j - 1]);
  std::vector<double> a;
  for (const Angle station : a_stations) a.push_back(station.in_radians());
  t.a_low = a.front(), t.a_high = a.back();
  const std::size_t last = a.size() - 1, inner_low = std::min<std::size_t>(1, last), inner_high = last - inner_low;
  // Rows beyond the ends, so far out that the rim, which has no slopes, is no neighbour of anything within.
  for (const int k : {3, 2, 1}) {
    const double gap = last > 0 ? a[1] - a[0] : widest, out = k * std::max(gap, widest);
    const double carry = last > 0 ? out / gap : 0;
    t.rows.push_back({a[0] - out, 0, inner_low, 1 + carry, -carry});
  }
  for (std::size_t i = 0; i <= last; ++i) t.rows.push_back({a[i], i, i, 1, 0});
  for (const int k : {1, 2, 3}) {
    const double gap = last > 0 ? a[last] - a[last - 1] : widest, out = k * std::max(gap, widest);
    const double carry = last > 0 ? out / gap : 0;
    t.rows.push_back({a[last] + out, last, inner_high, 1 + carry, -carry});
  }
  for (std::size_t row = 0; row < t.rows.size(); ++row)
    for (std::size_t column = 0; column < t.c.size(); ++column)
      for (const int turn : {-1, 0, 1}) {
        const Delaunay::Vertex_handle vertex = t.delaunay.insert(Point(t.rows[row].a, t.c[column] + turn * kTurn_rad));
        vertex->info() = t.sites.size();
        t.sites.push_back({row, column});
      }
  // Slopes where a turn lies all around; a copy has those of its original.
  for (const Delaunay::Vertex_handle vertex : t.delaunay.finite_vertex_handles()) {
    const Triangulation::Site& site = t.sites[vertex->info()];
    const bool rim = site.row == 0 || site.row + 1 == t.rows.size();
    if (vertex->info() % 3 != 1 || rim) continue;
    t.fit_slope(vertex);
  }
  for (std::size_t k = 0; k < t.sites.size(); ++k) {
    Triangulation::Site& site = t.sites[k];
    const Triangulation::Site& from = t.sites[k - k % 3 + 1];
    if (k % 3 != 1 && from.slopes) site.slope = from.slope, site.slopes = true;
  }
}

NaturalNeighbour::~NaturalNeighbour() = default;
NaturalNeighbour::NaturalNeighbour(NaturalNeighbour&&) noexcept = default;
NaturalNeighbour& NaturalNeighbour::operator=(NaturalNeighbour&&) noexcept = default;

Eigen::VectorXd NaturalNeighbour::weights(Angle a, Angle c) const {
  const Triangulation& t = *triangulation_;
  Eigen::VectorXd linear = Eigen::VectorXd::Zero(t.nodes()), sloped = linear;
  const double x = std::clamp(a.in_radians(), t.a_low, t.a_high);
  const double y = c.in_radians() - kTurn_rad * std::floor((c.in_radians() - t.c.front()) / kTurn_rad);
  Coordinates around;
  const auto found =
      CGAL::natural_neighbor_coordinates_2(t.delaunay, Point(x, y), std::back_inserter(around), TakeHandle());
  double inverse_r = 0, r1 = 0, r2 = 0;
  for (const auto& [vertex, coordinate] : around) {
    const Triangulation::Site& site = t.sites[vertex->info()];
    const Eigen::Vector2d step(x - vertex->point().x(), y - vertex->point().y());
    const double l = coordinate / found.second, r = step.norm();
    if (r < 1e-12) {
      linear.setZero();
      t.add_value(site, 1, linear);
      return linear;
    }
    inverse_r += l / r, r1 += l * r, r2 += l * r * r;
    t.add_value(site, l, linear);
    t.add_value(site, l / r, sloped);
    if (site.slopes) sloped += l / r * (site.slope.transpose() * step);
  }
  const double alpha = r1 / inverse_r;
  return (alpha * linear + r2 / inverse_r * sloped) / (alpha + r2);
}

}  // namespace trunnion
