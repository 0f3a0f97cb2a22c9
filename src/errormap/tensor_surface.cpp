#include "errormap/tensor_surface.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "units/angle.h"

namespace trunnion {
namespace {

std::vector<double> radians(const std::vector<Angle>& stations) {
  std::vector<double> x;
  for (const Angle station : stations) x.push_back(station.in_radians());
  return x;
}

Eigen::Index piece_of(const std::vector<double>& x, double at) {
  const auto upper = std::upper_bound(x.begin() + 1, x.end() - 1, at);
  return upper - x.begin() - 1;
}

Eigen::Matrix<double, 6, Eigen::Dynamic> columns(const std::vector<PoseError>& errors) {
  Eigen::Matrix<double, 6, Eigen::Dynamic> m(6, static_cast<Eigen::Index>(errors.size()));
  for (std::size_t k = 0; k < errors.size(); ++k) m.col(static_cast<Eigen::Index>(k)) = errors[k].vector();
  return m;
}

}  // namespace

TensorSurface::TensorSurface(ErrorGrid grid, StationWeights a_weights, StationWeights c_weights)
    : grid_(std::move(grid)),
      tilt_(columns(grid_.tilt)),
      turn_(columns(grid_.turn)),
      a_weights_(std::move(a_weights)),
      c_weights_(std::move(c_weights)) {}

RotaryErrors TensorSurface::at(IndexedPosition position) const {
  check(position.a);
  const Eigen::VectorXd wa = a_weights_(position.a.in_radians()), wc = c_weights_(position.c.in_radians());
  Vector6d turn = Vector6d::Zero();
  for (Eigen::Index i = 0; i < wa.size(); ++i)
    if (wa[i] != 0) turn += wa[i] * (turn_.middleCols(i * wc.size(), wc.size()) * wc);
  return {PoseError::from_vector(tilt_ * wa), PoseError::from_vector(turn)};
}

Eigen::Matrix<double, 12, Eigen::Dynamic> TensorSurface::jacobian(IndexedPosition position) const {
  check(position.a);
  const Eigen::VectorXd wa = a_weights_(position.a.in_radians()), wc = c_weights_(position.c.in_radians());
  Eigen::Matrix<double, 12, Eigen::Dynamic> b =
      Eigen::Matrix<double, 12, Eigen::Dynamic>::Zero(12, coefficient_count());
  for (Eigen::Index i = 0; i < wa.size(); ++i) {
    b.block<6, 6>(0, 6 * i).diagonal().setConstant(wa[i]);
    for (Eigen::Index j = 0; j < wc.size(); ++j)
      b.block<6, 6>(6, 6 * (wa.size() + i * wc.size() + j)).diagonal().setConstant(wa[i] * wc[j]);
  }
  return b;
}

StationWeights linear_weights(const std::vector<Angle>& stations) {
  const std::vector<double> x = radians(stations);
  const auto n = static_cast<Eigen::Index>(x.size());
  return [x, n](double at) {
    Eigen::VectorXd w = Eigen::VectorXd::Zero(n);
    if (n == 1) return Eigen::VectorXd(Eigen::VectorXd::Ones(1));
    const Eigen::Index i = piece_of(x, at);
    const auto k = static_cast<std::size_t>(i);
    w[i + 1] = (at - x[k]) / (x[k + 1] - x[k]);
    w[i] = 1 - w[i + 1];
    return w;
  };
}

StationWeights cubic_weights(const std::vector<Angle>& stations) {
  const std::vector<double> x = radians(stations);
  const auto n = static_cast<Eigen::Index>(x.size());
  if (n < 3) return linear_weights(stations);
  // Second derivatives m at the stations, linear in the values: K m = L y.
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(n, n), l = Eigen::MatrixXd::Zero(n, n);
  const auto h = [&](Eigen::Index i) { return x[static_cast<std::size_t>(i + 1)] - x[static_cast<std::size_t>(i)]; };
  for (Eigen::Index i = 1; i + 1 < n; ++i) {
    k(i, i - 1) = h(i - 1) / 6;
    k(i, i) = (h(i - 1) + h(i)) / 3;
    k(i, i + 1) = h(i) / 6;
    l(i, i - 1) = 1 / h(i - 1);
    l(i, i) = -1 / h(i - 1) - 1 / h(i);
    l(i, i + 1) = 1 / h(i);
  }
  if (n == 3) {  // natural ends
    k(0, 0) = k(2, 2) = 1;
  } else {  // not-a-knot: one cubic over the first two pieces, and over the last two
    k(0, 0) = -1 / h(0), k(0, 1) = 1 / h(0) + 1 / h(1), k(0, 2) = -1 / h(1);
    k(n - 1, n - 3) = -1 / h(n - 3), k(n - 1, n - 2) = 1 / h(n - 3) + 1 / h(n - 2), k(n - 1, n - 1) = -1 / h(n - 2);
  }
  const Eigen::MatrixXd second = k.partialPivLu().solve(l);
  return [x, second](double at) {
    const Eigen::Index i = piece_of(x, at);
    const double left = x[static_cast<std::size_t>(i)], step = x[static_cast<std::size_t>(i + 1)] - left;
    const double b = (at - left) / step, a = 1 - b;
    Eigen::VectorXd w = (step * step / 6) * ((a * a * a - a) * second.row(i) + (b * b * b - b) * second.row(i + 1));
    w[i] += a;
    w[i + 1] += b;
    return w;
  };
}

StationWeights trigonometric_weights(const std::vector<Angle>& stations) {
  const std::vector<double> x = radians(stations);
  const auto n = static_cast<Eigen::Index>(x.size());
  // Even n: the last harmonic keeps one phase only, the one that the nodes see best. The determinant of the collocation
  // is const * sin(sum(x) / 2 - phase) * prod sin((x_i - x_j) / 2), so this phase makes it as large as it can be, and
  // the stations, being different modulo a turn, always determine the interpolant. Equidistant: a cosine from a
  // station.
  double phase = 0;
  if (n % 2 == 0) phase = 0.5 * std::accumulate(x.begin(), x.end(), 0.0) - std::numbers::pi / 2;
  const auto basis = [n, phase](double at) {
    Eigen::VectorXd b(n);
    b[0] = 1;
    for (Eigen::Index k = 1; 2 * k < n; ++k) {
      b[2 * k - 1] = std::cos(static_cast<double>(k) * at);
      b[2 * k] = std::sin(static_cast<double>(k) * at);
    }
    if (n % 2 == 0) b[n - 1] = std::cos(static_cast<double>(n / 2) * at - phase);
    return b;
  };
  Eigen::MatrixXd collocation(n, n);
  for (Eigen::Index j = 0; j < n; ++j) collocation.row(j) = basis(x[static_cast<std::size_t>(j)]);
  const Eigen::MatrixXd inverse_transposed = collocation.inverse().transpose();
  return [basis, inverse_transposed](double at) { return Eigen::VectorXd(inverse_transposed * basis(at)); };
}

StationWeights periodic_linear_weights(const std::vector<Angle>& stations) {
  const std::vector<double> x = radians(stations);
  const auto n = static_cast<Eigen::Index>(x.size());
  return [x, n](double at) {
    Eigen::VectorXd w = Eigen::VectorXd::Zero(n);
    const double turned = at - kTurn_rad * std::floor((at - x[0]) / kTurn_rad);
    const auto upper = std::upper_bound(x.begin(), x.end(), turned);
    const auto i = static_cast<std::size_t>(upper - x.begin() - 1);
    const double right = i + 1 < x.size() ? x[i + 1] : x[0] + kTurn_rad;
    const double v = (turned - x[i]) / (right - x[i]);
    w[static_cast<Eigen::Index>(i)] += 1 - v;
    w[static_cast<Eigen::Index>((i + 1) % x.size())] += v;
    return w;
  };
}

}  // namespace trunnion
