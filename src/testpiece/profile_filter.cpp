#include "testpiece/profile_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "error.h"
#include "units/angle.h"

namespace trunnion {
namespace {

/// The part of the turn, in rad, that each point stands for: half the way to either neighbour.
std::vector<double> shares(const RoundnessTrace& trace) {
  const std::size_t n = trace.phi_rad.size();
  std::vector<double> angle(n);
  for (std::size_t i = 0; i < n; ++i)
    angle[i] = trace.phi_rad[i] - kTurn_rad * std::floor(trace.phi_rad[i] / kTurn_rad);
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return angle[i]; });
  std::vector<double> share(n);
  for (std::size_t k = 0; k < n; ++k) {
    const double before = k > 0 ? angle[order[k - 1]] : angle[order[n - 1]] - kTurn_rad;
    const double after = k + 1 < n ? angle[order[k + 1]] : angle[order[0]] + kTurn_rad;
    share[order[k]] = (after - before) / 2;
  }
  return share;
}

}  // namespace

RoundnessTrace gaussian_filtered(const RoundnessTrace& trace, double cutoff_upr) {
  if (!(cutoff_upr > 0)) throw UsageError("filter: a cutoff above 0 undulations per revolution is wanted");
  // The weight function whose transmission is exp(-pi (alpha k / cutoff)^2) is Gaussian in the angle, with
  // standard deviation s = alpha sqrt(2 pi) / cutoff  (its transform is exp(-k^2 s^2 / 2)).
  const double s = std::sqrt(2 * std::numbers::ln2) / cutoff_upr;
  const std::vector<double> share = shares(trace);
  const std::size_t n = trace.phi_rad.size();
  RoundnessTrace filtered = trace;
  for (std::size_t i = 0; i < n; ++i) {
    double sum = 0, weight = 0;
    for (std::size_t j = 0; j < n; ++j) {
      const double apart = std::remainder(trace.phi_rad[j] - trace.phi_rad[i], kTurn_rad);
      double w = 0;
      for (const double turn : {-kTurn_rad, 0.0, kTurn_rad}) w += std::exp(-0.5 * std::pow((apart + turn) / s, 2));
      sum += w * share[j] * trace.radial_mm[j];
      weight += w * share[j];
    }
    filtered.radial_mm[i] = sum / weight;
  }
  return filtered;
}

std::vector<Undulation> undulations(const RoundnessTrace& trace, int highest) {
  const std::vector<double> share = shares(trace);
  std::vector<Undulation> found;
  for (int k = 0; k <= highest; ++k) {
    double c = 0, s = 0;
    for (std::size_t i = 0; i < share.size(); ++i) {
      c += share[i] * trace.radial_mm[i] * std::cos(k * trace.phi_rad[i]);
      s += share[i] * trace.radial_mm[i] * std::sin(k * trace.phi_rad[i]);
    }
    if (k == 0)
      found.push_back({0, c / kTurn_rad, 0});
    else
      found.push_back({k, 2 * std::hypot(c, s) / kTurn_rad, std::atan2(s, c)});
  }
  return found;
}

}  // namespace trunnion
