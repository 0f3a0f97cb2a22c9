#include "testpiece/roundness.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "error.h"
#include "units/angle.h"

namespace trunnion {
namespace {

using Eigen::Vector2d;

constexpr int kSteps = 30;
constexpr double kStill = 1e-8;  ///< relative to the radius: a last step this small leaves its square

struct Trace {
  double radius_mm;
  std::vector<Vector2d> direction;  ///< of each point from the nominal centre
  std::vector<double> radial_mm;
  std::array<std::size_t, 3> around;  ///< three points whose triangle holds the centre
};

Trace checked(const RoundnessTrace& given) {
  const std::size_t n = given.phi_rad.size();
  if (n != given.radial_mm.size() || n < 4)
    throw InputError("a roundness trace of " + std::to_string(n) + " points; four or more are wanted");
  if (!(given.nominal_radius_mm + *std::ranges::min_element(given.radial_mm) > 0))
    throw InputError("a roundness trace reaches its nominal centre; points of a circle about it are wanted");
  Trace trace{given.nominal_radius_mm, {}, given.radial_mm, {}};
  trace.direction.reserve(n);
  for (const double phi : given.phi_rad) trace.direction.emplace_back(std::cos(phi), std::sin(phi));

  std::vector<double> angle(n);
  for (std::size_t i = 0; i < n; ++i) {
    angle[i] = std::fmod(given.phi_rad[i] - given.phi_rad[0], kTurn_rad);
    if (angle[i] < 0) angle[i] += kTurn_rad;
  }
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return angle[i]; });
  for (std::size_t i = 0; i < n; ++i) {
    const double next = i + 1 < n ? angle[order[i + 1]] : kTurn_rad + angle[order[0]];
    if (next - angle[order[i]] >= std::numbers::pi)
      throw InputError("a roundness trace leaves half a turn without points; points all round are wanted");
  }
  const auto beyond = std::ranges::find_if(order, [&](std::size_t i) { return angle[i] >= std::numbers::pi; });
  trace.around = {order[0], *std::prev(beyond), *beyond};
  return trace;
}

/// Distances from `center` less the nominal radius, free of cancellation, and their directions.
struct Polar {
  std::vector<double> radial_mm;
  std::vector<Vector2d> direction;
};

Polar about(const Trace& trace, const Vector2d& center) {
  const std::size_t n = trace.radial_mm.size();
  Polar polar{std::vector<double>(n), std::vector<Vector2d>(n)};
  const double r0 = trace.radius_mm;
  for (std::size_t i = 0; i < n; ++i) {
    const double r = r0 + trace.radial_mm[i];
    const Vector2d from_center = r * trace.direction[i] - center;
    const double distance = from_center.norm();
    const double excess = trace.radial_mm[i] * (r0 + r) - 2 * r * center.dot(trace.direction[i]) + center.squaredNorm();
    polar.radial_mm[i] = excess / (distance + r0);
    polar.direction[i] = from_center / distance;
  }
  return polar;
}

ReferenceCircle finished(const Trace& trace, const Vector2d& center, double size_mm) {
  const Polar polar = about(trace, center);
  const auto [low, high] = std::ranges::minmax(polar.radial_mm);
  return {center, size_mm, high - low};
}

/// Maximises sum lambda_i v_i over lambda >= 0 with sum lambda_i a_i = b, by the simplex method from a feasible basis;
/// returns the multipliers y, for which y . a_i >= v_i everywhere and y . b is the maximum.
template <int K>
Eigen::Matrix<double, K, 1> simplex(const std::vector<Eigen::Matrix<double, K, 1>>& columns,
                                    const std::vector<double>& values, const Eigen::Matrix<double, K, 1>& b,
                                    std::array<std::size_t, K> basis) {
  using Vector = Eigen::Matrix<double, K, 1>;
  double scale = 0;
  for (const double v : values) scale = std::max(scale, std::abs(v));
  const double tolerance = 1e-14 * scale;
  constexpr int kDantzig = 200, kMost = 5000;  // Bland's rule after that: slower, but it cannot cycle
  Vector y = Vector::Zero();
  for (int step = 0; step < kMost; ++step) {
    Eigen::Matrix<double, K, K> m;
    Vector v;
    for (int k = 0; k < K; ++k) m.col(k) = columns[basis[k]], v[k] = values[basis[k]];
    const Eigen::Matrix<double, K, K> inverse = m.inverse();
    y = inverse.transpose() * v;
    std::size_t entering = columns.size();
    double gain = tolerance;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const double g = values[i] - y.dot(columns[i]);
      if (g <= gain) continue;
      entering = i;
      if (step >= kDantzig) break;
      gain = g;
    }
    if (entering == columns.size()) break;
    const Vector share = inverse * b, change = inverse * columns[entering];
    int leaving = -1;
    double ratio = 0;
    for (int k = 0; k < K; ++k) {
      if (change[k] < 1e-12) continue;
      const double r = std::max(share[k], 0.0) / change[k];
      if (leaving < 0 || r < ratio || (r == ratio && basis[k] < basis[leaving])) leaving = k, ratio = r;
    }
    if (leaving < 0) break;
    basis[static_cast<std::size_t>(leaving)] = entering;
  }
  return y;
}

/// The circle about all points (sign = 1), or, with all signs turned, the largest one within them (sign = -1).
ReferenceCircle extremal_circle(const RoundnessTrace& given, double sign) {
  const Trace trace = checked(given);
  Vector2d center = Vector2d::Zero();
  double size = 0;
  for (int step = 0; step < kSteps; ++step) {
    Polar polar = about(trace, center);
    std::vector<Eigen::Vector3d> columns;
    columns.reserve(polar.direction.size());
    for (const Vector2d& e : polar.direction) columns.emplace_back(1, e.x(), e.y());
    for (double& r : polar.radial_mm) r *= sign;
    const Eigen::Vector3d y = simplex<3>(columns, polar.radial_mm, {1, 0, 0}, trace.around);
    center += sign * y.tail<2>();
    size = sign * y[0];
    if (y.tail<2>().norm() < kStill * trace.radius_mm) break;
  }
  return finished(trace, center, size);
}

}  // namespace

ReferenceCircle least_squares_circle(const RoundnessTrace& given) {
  const Trace trace = checked(given);
  Vector2d center = Vector2d::Zero();
  double size = 0;
  for (int step = 0; step < kSteps; ++step) {
    const Polar polar = about(trace, center);
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < polar.radial_mm.size(); ++i) {
      const Eigen::Vector3d row(1, polar.direction[i].x(), polar.direction[i].y());
      normal += row * row.transpose();
      right += row * polar.radial_mm[i];
    }
    const Eigen::Vector3d x = normal.inverse() * right;
    center += x.tail<2>();
    size = x[0];
    if (x.tail<2>().norm() < kStill * trace.radius_mm) break;
  }
  return finished(trace, center, size);
}

ReferenceCircle minimum_zone_circle(const RoundnessTrace& given) {
  const Trace trace = checked(given);
  const std::size_t n = trace.radial_mm.size();
  // Multipliers (u, l, x, y): u + x c + y s >= r (columns 0 … n-1), -l - x c - y s >= -r (columns n … 2n-1); u - l
  // least.
  const std::array<std::size_t, 4> start = {trace.around[0], trace.around[1], trace.around[2], n + trace.around[0]};
  Vector2d center = Vector2d::Zero();
  double size = 0;
  for (int step = 0; step < kSteps; ++step) {
    const Polar polar = about(trace, center);
    std::vector<Eigen::Vector4d> columns(2 * n);
    std::vector<double> values(2 * n);
    for (std::size_t i = 0; i < n; ++i) {
      const Vector2d& e = polar.direction[i];
      columns[i] = {1, 0, e.x(), e.y()};
      columns[n + i] = {0, -1, -e.x(), -e.y()};
      values[i] = polar.radial_mm[i];
      values[n + i] = -polar.radial_mm[i];
    }
    const Eigen::Vector4d y = simplex<4>(columns, values, {1, -1, 0, 0}, start);
    center += y.tail<2>();
    size = (y[0] + y[1]) / 2;
    if (y.tail<2>().norm() < kStill * trace.radius_mm) break;
  }
  return finished(trace, center, size);
}

ReferenceCircle maximum_inscribed_circle(const RoundnessTrace& trace) { return extremal_circle(trace, -1); }

ReferenceCircle minimum_circumscribed_circle(const RoundnessTrace& trace) { return extremal_circle(trace, 1); }

double roundness_about_mm(const RoundnessTrace& given, const Eigen::Vector2d& center_mm) {
  return finished(checked(given), center_mm, 0).roundness_mm;
}

}  // namespace trunnion
