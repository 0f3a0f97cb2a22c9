#include "errormap/baked_map.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "error.h"
#include "units/number_text.h"

namespace trunnion {
namespace {

constexpr std::size_t kPerNode = 24;
constexpr double kTurnsPerRad = 1 / (2 * std::numbers::pi);
constexpr double kRounding_rad = 1e-9 * std::numbers::pi / 180;

/// Weights of f(0), f'(0), f(1), f'(1) at t.
std::array<double, 4> hermite(double t) {
  const double s = 1 - t;
  return {s * s * (1 + 2 * t), t * s * s, t * t * (1 + 2 * s), -t * t * s};
}

std::array<double, 4> hermite_slope(double t) {
  const double s = 1 - t;
  return {-6 * t * s, s * (1 - 3 * t), 6 * t * s, t * (3 * t - 2)};
}

using Map6 = Eigen::Map<const Vector6d>;

/// Weights wa and wc over the four nodes of a cell; `lower` and `upper` are its sides at u = 0 and 1.
Vector6d blend(const double* lower_left, const double* lower_right, const double* upper_left, const double* upper_right,
               const std::array<double, 4>& wa, const std::array<double, 4>& wc) {
  const auto node = [](const double* n, double f, double fu, double fv, double fuv) -> Vector6d {
    return f * Map6(n) + fu * Map6(n + 6) + fv * Map6(n + 12) + fuv * Map6(n + 18);
  };
  return node(lower_left, wa[0] * wc[0], wa[1] * wc[0], wa[0] * wc[1], wa[1] * wc[1]) +
         node(lower_right, wa[0] * wc[2], wa[1] * wc[2], wa[0] * wc[3], wa[1] * wc[3]) +
         node(upper_left, wa[2] * wc[0], wa[3] * wc[0], wa[2] * wc[1], wa[3] * wc[1]) +
         node(upper_right, wa[2] * wc[2], wa[3] * wc[2], wa[2] * wc[3], wa[3] * wc[3]);
}

/// Slope by differences of fourth order over five equidistant nodes, at the one of index `at`.
Vector6d slope(const std::array<Vector6d, 5>& f, std::size_t at) {
  switch (at) {
    case 0:
      return (-25 * f[0] + 48 * f[1] - 36 * f[2] + 16 * f[3] - 3 * f[4]) / 12;
    case 1:
      return (-3 * f[0] - 10 * f[1] + 18 * f[2] - 6 * f[3] + f[4]) / 12;
    case 3:
      return (-f[0] + 6 * f[1] - 18 * f[2] + 10 * f[3] + 3 * f[4]) / 12;
    case 4:
      return (3 * f[0] - 16 * f[1] + 36 * f[2] - 48 * f[3] + 25 * f[4]) / 12;
    default:
      return (f[0] - 8 * f[1] + 8 * f[3] - f[4]) / 12;
  }
}

[[noreturn]] void refuse(double a_rad, double c_rad, Range<Angle> range) {
  if (!std::isfinite(c_rad)) throw RangeError("C stands at no number");
  throw RangeError(printed("tilt %.6g deg lies outside the probed range %.6g .. %.6g deg",
                           Angle::radians(a_rad).in_degrees(), range.low.in_degrees(), range.high.in_degrees()));
}

struct Worst {
  double displacement_mm = 0, rotation_rad = 0;
  void take(const Vector6d& difference, double lever_mm) {
    const double turn = difference.tail<3>().norm();
    displacement_mm = std::max(displacement_mm, difference.head<3>().norm() + lever_mm * turn);
    rotation_rad = std::max(rotation_rad, turn);
  }
  double against(const BakeTolerance& tolerance) const {
    return std::max(displacement_mm / tolerance.displacement.in_millimetres(),
                    rotation_rad / tolerance.rotation.in_radians());
  }
};

}  // namespace

BakedMap::BakedMap(const Original& original, Range<Angle> a_range, const BakeTolerance& tolerance) : a_range_(a_range) {
  a_low_ = a_range.low.in_radians();
  const double span = (a_range.high - a_range.low).in_radians();
  const auto sized = [&](std::size_t a_cells, std::size_t c_nodes) {
    a_nodes_ = a_cells + 1, c_nodes_ = c_nodes;
    cells_per_rad_a_ = span > 0 ? static_cast<double>(a_cells) / span : 0;
    bake(original);
  };
  const double lever_mm = tolerance.lever.in_millimetres();
  const double a_cell = span / 3, c_cell = 2 * std::numbers::pi / 3;
  std::size_t a_cells = std::clamp<std::size_t>(static_cast<std::size_t>(span / 0.13), 4, 64), c_nodes = 48;
  while (true) {
    sized(a_cells, c_nodes);
    Worst all, along_a, along_c;
    for (std::size_t i = 0; i <= 3 * a_cells; ++i)
      for (std::size_t j = 0; j < 3 * c_nodes; ++j) {
        if (i % 3 == 0 && j % 3 == 0) continue;
        const double a = i == 3 * a_cells ? a_range.high.in_radians()
                                          : a_low_ + static_cast<double>(i) * a_cell / static_cast<double>(a_cells);
        const double c = static_cast<double>(j) * c_cell / static_cast<double>(c_nodes);
        const Vector6d difference = value(place(a, c)) - original({Angle::radians(a), Angle::radians(c)}).vector();
        all.take(difference, lever_mm);
        if (j % 3 == 0) along_a.take(difference, lever_mm);
        if (i % 3 == 0) along_c.take(difference, lever_mm);
      }
    error_ = {Length::millimetres(all.displacement_mm), Angle::radians(all.rotation_rad)};
    const bool refine_a = along_a.against(tolerance) > 0.4 && span > 0, refine_c = along_c.against(tolerance) > 0.4;
    const std::size_t next_a = refine_a || !refine_c ? 2 * a_cells : a_cells, next_c = refine_c ? 2 * c_nodes : c_nodes;
    if (meets(tolerance) || (next_a + 1) * next_c > kMaxNodes) return;
    a_cells = next_a, c_nodes = next_c;
  }
}

void BakedMap::bake(const Original& original) {
  const std::size_t rows = a_nodes_, columns = c_nodes_;
  nodes_.assign(rows * columns * kPerNode, 0);
  const auto part = [&](std::size_t i, std::size_t j, std::size_t kind) {
    return Eigen::Map<Vector6d>(nodes_.data() + (i * columns + j) * kPerNode + 6 * kind);
  };
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) {
      const double a = i + 1 == rows || cells_per_rad_a_ == 0 ? a_range_.high.in_radians()
                                                              : a_low_ + static_cast<double>(i) / cells_per_rad_a_;
      const double c = 2 * std::numbers::pi * static_cast<double>(j) / static_cast<double>(columns);
      part(i, j, 0) = original({Angle::radians(a), Angle::radians(c)}).vector();
    }
  const auto by_c = [&](std::size_t i, std::size_t j, std::size_t kind) {
    std::array<Vector6d, 5> f;
    for (std::size_t k = 0; k < 5; ++k) f[k] = part(i, (j + columns + k - 2) % columns, kind);
    return slope(f, 2);
  };
  for (std::size_t i = 0; i < rows; ++i) {
    const std::size_t first = std::min(i < 2 ? 0 : i - 2, rows - 5);
    for (std::size_t j = 0; j < columns; ++j) {
      std::array<Vector6d, 5> f;
      for (std::size_t k = 0; k < 5; ++k) f[k] = part(first + k, j, 0);
      part(i, j, 1) = slope(f, i - first);
      part(i, j, 2) = by_c(i, j, 0);
    }
  }
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) part(i, j, 3) = by_c(i, j, 1);
}

inline BakedMap::Place BakedMap::place(double a_rad, double c_rad) const {
  const double last = static_cast<double>(a_nodes_ - 1);
  const double u = (a_rad - a_low_) * cells_per_rad_a_;
  const double slack = kRounding_rad * cells_per_rad_a_;
  const double turns = c_rad * kTurnsPerRad;
  const bool inside =
      cells_per_rad_a_ > 0 ? u >= -slack && u <= last + slack : std::abs(a_rad - a_low_) <= kRounding_rad;
  if (!inside || !(std::abs(turns) < 1e12)) refuse(a_rad, c_rad, a_range_);
  // Truncation and a step down: std::floor is a library call on plain x86-64.
  const auto whole = static_cast<long long>(turns);
  double part = turns - static_cast<double>(whole);
  if (part < 0) part += 1;
  const double v = part * static_cast<double>(c_nodes_);
  std::size_t j = static_cast<std::size_t>(static_cast<long long>(v));
  const double dv = v - static_cast<double>(j);
  if (j >= c_nodes_) j = 0;  // a hair below a whole turn
  const auto cell = static_cast<long long>(std::clamp(u, 0.0, last - 1));
  return {static_cast<std::size_t>(cell), j, j + 1 == c_nodes_ ? 0 : j + 1, u - static_cast<double>(cell), dv};
}

inline Vector6d BakedMap::value(const Place& p) const {
  const double* lower = nodes_.data() + p.i * c_nodes_ * kPerNode;
  const double* upper = lower + c_nodes_ * kPerNode;
  const std::size_t j = p.j * kPerNode, next = p.j_next * kPerNode;
  return blend(lower + j, lower + next, upper + j, upper + next, hermite(p.u), hermite(p.v));
}

PoseError BakedMap::at(IndexedPosition position) const {
  return PoseError::from_vector(value(place(position.a.in_radians(), position.c.in_radians())));
}

PoseErrorSlopes BakedMap::with_slopes(IndexedPosition position) const {
  const Place p = place(position.a.in_radians(), position.c.in_radians());
  const double* lower = nodes_.data() + p.i * c_nodes_ * kPerNode;
  const double* upper = lower + c_nodes_ * kPerNode;
  const std::size_t j = p.j * kPerNode, next = p.j_next * kPerNode;
  const auto a = hermite(p.u), a_slope = hermite_slope(p.u), c = hermite(p.v), c_slope = hermite_slope(p.v);
  // Along c first, for the values and u slopes of both sides; both weights of a then share them.
  const auto along_c = [](const double* left, const double* right, const std::array<double, 4>& w, std::size_t k) {
    return w[0] * left[k] + w[1] * left[k + 12] + w[2] * right[k] + w[3] * right[k + 12];
  };
  Vector6d value, by_a, by_c;
  for (std::size_t k = 0; k < 6; ++k) {
    const double f0 = along_c(lower + j, lower + next, c, k), g0 = along_c(lower + j, lower + next, c, k + 6);
    const double f1 = along_c(upper + j, upper + next, c, k), g1 = along_c(upper + j, upper + next, c, k + 6);
    const double df0 = along_c(lower + j, lower + next, c_slope, k),
                 dg0 = along_c(lower + j, lower + next, c_slope, k + 6);
    const double df1 = along_c(upper + j, upper + next, c_slope, k),
                 dg1 = along_c(upper + j, upper + next, c_slope, k + 6);
    const Eigen::Index i = static_cast<Eigen::Index>(k);
    value[i] = a[0] * f0 + a[1] * g0 + a[2] * f1 + a[3] * g1;
    by_a[i] = a_slope[0] * f0 + a_slope[1] * g0 + a_slope[2] * f1 + a_slope[3] * g1;
    by_c[i] = a[0] * df0 + a[1] * dg0 + a[2] * df1 + a[3] * dg1;
  }
  const double per_rad_c = static_cast<double>(c_nodes_) * kTurnsPerRad;
  return {PoseError::from_vector(value), PoseError::from_vector(cells_per_rad_a_ * by_a),
          PoseError::from_vector(per_rad_c * by_c)};
}

void BakedMap::deviations_mm(std::span<const double> a_rad, std::span<const double> c_rad,
                             std::span<const Eigen::Vector3d> points_r_mm,
                             std::span<Eigen::Vector3d> deviations) const {
  assert(a_rad.size() == c_rad.size() && a_rad.size() == points_r_mm.size() && a_rad.size() == deviations.size());
  for (std::size_t k = 0; k < a_rad.size(); ++k) {
    const Vector6d e = value(place(a_rad[k], c_rad[k]));
    const Eigen::Vector3d& p = points_r_mm[k];
    // (Rx Ry Rz - I) p, one axis after the other: sin w = w, 1 - cos w = w^2 / 2.
    const double wx = e[3], wy = e[4], wz = e[5];
    const double half_x = 0.5 * wx * wx, half_y = 0.5 * wy * wy, half_z = 0.5 * wz * wz;
    const double zx = -wz * p[1] - half_z * p[0], zy = wz * p[0] - half_z * p[1];
    const double x1 = p[0] + zx, y1 = p[1] + zy;
    const double yx = wy * p[2] - half_y * x1, yz = -wy * x1 - half_y * p[2];
    const double z2 = p[2] + yz;
    deviations[k] = {e[0] + zx + yx, e[1] + zy - wx * z2 - half_x * y1, e[2] + yz + wx * y1 - half_x * z2};
  }
}

}  // namespace trunnion
