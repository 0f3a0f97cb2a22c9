#include "identification/outliers.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "identification/distributions.h"

namespace trunnion {
namespace {

double normalised(const LinearProblem& problem, const SmoothFit& fit, std::size_t i, double weight) {
  const Reading& reading = problem.readings[i];
  const double noise = reading.sigma * (reading.angular ? fit.prior.angle_noise : fit.prior.length_noise);
  // A weight shrinks the influence, not the noise: r_i of the unweighted reading is 1 - h / w.
  const double leverage = weight > 0 ? (1 - fit.redundancy[i]) / weight : 0;
  return fit.residual[i] / (noise * std::sqrt(std::max(1e-3, 1 - leverage)));
}

double robust_scale(std::vector<double> z) {
  if (z.empty()) return 1;
  for (double& value : z) value = std::abs(value);
  const auto middle = z.begin() + static_cast<std::ptrdiff_t>(z.size() / 2);
  std::nth_element(z.begin(), middle, z.end());
  return std::max(1e-12, *middle / 0.6745);
}

/// Whether `suspects` crowd in one label of `label_of` far more than chance would have it.
template <class Label>
std::string crowd_in(const LinearProblem& problem, const std::vector<Outlier>& suspects, const char* what,
                     Label label_of) {
  std::map<std::string, std::pair<double, double>> counts;  // suspects, readings
  for (std::size_t i = 0; i < problem.readings.size(); ++i) ++counts[label_of(i)].second;
  for (const Outlier& o : suspects) ++counts[label_of(o.reading)].first;
  if (counts.size() < 2) return {};
  const double n = static_cast<double>(problem.readings.size()), k = static_cast<double>(suspects.size());
  for (const auto& [label, count] : counts) {
    if (count.first < 4) continue;
    const double tail = binomial_tail(count.first, k, count.second / n) * static_cast<double>(counts.size());
    if (tail < 1e-3)
      return std::to_string(static_cast<int>(count.first)) + " of " + std::to_string(suspects.size()) + " in " + what +
             " " + label;
  }
  return {};
}

std::string crowd(const LinearProblem& problem, const std::vector<Outlier>& suspects) {
  const ObservationSet& set = *problem.observations;
  std::string found;
  if (!set.artifacts.empty())
    found = crowd_in(problem, suspects, "artifact",
                     [&](std::size_t i) { return set.artifacts[set.rows[problem.readings[i].row].artifact]; });
  if (found.empty())
    found = crowd_in(problem, suspects, "pose", [&](std::size_t i) {
      const IndexedPosition at = problem.poses[problem.readings[i].pose].at;
      return std::to_string(std::lround(at.a.in_degrees())) + ", " + std::to_string(std::lround(at.c.in_degrees()));
    });
  if (found.empty() && set.rows.size() >= 40)
    found = crowd_in(problem, suspects, "eighth of the run", [&](std::size_t i) {
      return std::to_string(1 + 8 * static_cast<std::size_t>(problem.readings[i].row) / set.rows.size());
    });
  return found;
}

}  // namespace

OutlierSearch find_outliers(const LinearProblem& problem, const HarmonicBasis& basis, const SmoothOptions& smooth,
                            const OutlierOptions& options) {
  const std::size_t n = problem.readings.size();
  OutlierSearch search;
  search.used.assign(n, true);
  SmoothOptions current = smooth;
  current.weights.assign(n, 1.0);
  int fits = 0;
  if (smooth.progress) current.progress = [&](double share) { smooth.progress((fits + share) / kMostOutlierFits); };
  const auto fitted = [&] {
    SmoothFit fit = fit_smooth(problem, basis, current);
    ++fits;
    return fit;
  };
  search.fit = fitted();
  const std::optional<SmoothPrior> given = smooth.prior;
  const auto all_normalised = [&] {
    std::vector<double> z(n);
    for (std::size_t i = 0; i < n; ++i) z[i] = normalised(problem, search.fit, i, current.weights[i]);
    return z;
  };
  std::vector<double> z = all_normalised();
  search.noise_scale = robust_scale(z);
  const auto far = [&](const std::vector<double>& values, double scale) {
    return std::ranges::count_if(values, [&](double v) { return std::abs(v) > options.threshold * scale; });
  };
  if (far(z, std::max(1.0, search.noise_scale)) == 0 && far(z, 1.0) == 0)
    return search;  // nothing to be robust against

  current.prior = search.fit.prior;
  for (int iteration = 0; iteration < kReweightings; ++iteration) {
    search.noise_scale = robust_scale(z);
    for (std::size_t i = 0; i < n; ++i) {
      const double u = z[i] / std::max(search.noise_scale, 0.5);
      current.weights[i] = 5 / (4 + u * u);
    }
    search.fit = fitted();
    z = all_normalised();
  }
  // The hyperparameters once more, now that outliers weigh little; then decide one by one on unweighted residuals.
  current.start = search.fit.prior;
  current.prior = given;
  search.fit = fitted();
  current.prior = search.fit.prior;
  z = all_normalised();
  search.noise_scale = robust_scale(z);
  const double scale = std::max(1.0, search.noise_scale);
  std::vector<Outlier> suspects;
  for (std::size_t i = 0; i < n; ++i)
    if (std::abs(z[i]) > options.threshold * scale) suspects.push_back({i, search.fit.residual[i], z[i]});
  for (int round = 0; round < kSnoopingRounds; ++round) {
    current.weights.assign(n, 1.0);
    for (const Outlier& o : suspects) current.weights[o.reading] = 0;
    search.fit = fitted();
    std::vector<Outlier> next;
    for (std::size_t i = 0; i < n; ++i) {
      const double value = normalised(problem, search.fit, i, current.weights[i]);
      if (std::abs(value) > options.threshold * scale) next.push_back({i, search.fit.residual[i], value});
    }
    const auto same = [](const Outlier& a, const Outlier& b) { return a.reading == b.reading; };
    const bool settled = std::ranges::equal(next, suspects, same);
    suspects = std::move(next);
    if (settled) break;
  }
  search.crowd = crowd(problem, suspects);
  const bool too_many = static_cast<double>(suspects.size()) > options.most_fraction * static_cast<double>(n);
  if (too_many && search.crowd.empty())
    search.crowd = std::to_string(suspects.size()) + " of " + std::to_string(n) + " readings, all over";
  if (!search.crowd.empty()) {
    // An effect is at work. Readings far beyond even its scatter may still be chips, if those do not crowd themselves.
    std::vector<double> sizes;
    for (const Outlier& o : suspects) sizes.push_back(std::abs(o.normalised));
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    const double far_beyond = 3 * *middle;
    const auto is_far = [&](const Outlier& o) { return std::abs(o.normalised) > far_beyond; };
    std::vector<Outlier> extreme;
    std::ranges::copy_if(suspects, std::back_inserter(extreme), is_far);
    const bool sparse = static_cast<double>(extreme.size()) <= options.most_fraction * static_cast<double>(n) &&
                        crowd(problem, extreme).empty();
    if (sparse) std::erase_if(suspects, is_far);
    search.crowded = std::move(suspects);
    suspects = sparse ? std::move(extreme) : std::vector<Outlier>();
  }
  search.removed = std::move(suspects);
  current.weights.assign(n, 1.0);
  for (const Outlier& o : search.removed) search.used[o.reading] = false, current.weights[o.reading] = 0;
  current.prior = given;
  search.fit = fitted();
  return search;
}

}  // namespace trunnion
