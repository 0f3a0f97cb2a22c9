#include "history/alarm.h"

#include <cmath>

namespace trunnion {
namespace {

/// The alarm of one error, if its largest of `values` is beyond `limit`.
std::optional<Alarm> alarm(const ErrorSeries& series, const Eigen::VectorXd& values, const Eigen::VectorXd& variance,
                           double limit) {
  Eigen::Index largest = 0;
  values.cwiseAbs().maxCoeff(&largest);
  Alarm a{.error = series.name,
          .unit = series.unit,
          .found = to_unit(values[largest], series.unit),
          .std = to_unit(std::sqrt(std::max(0.0, variance[largest])), series.unit),
          .limit = limit};
  if (std::abs(a.found) <= limit) return std::nullopt;
  a.proven = std::abs(a.found) - 2 * a.std > limit;
  if (!series.places.empty()) a.at = series.places[static_cast<std::size_t>(largest)];
  return a;
}

}  // namespace

std::vector<Alarm> find_alarms(const SeriesSet& set, const std::map<std::string, double>& values,
                               const std::map<std::string, double>& changes) {
  std::vector<Alarm> found;
  for (const auto* kind : {&set.locations, &set.functions, &set.parameters})
    for (const ErrorSeries& series : *kind) {
      const ErrorSeries::Point &first = series.points.front(), &last = series.points.back();
      if (const auto limit = values.find(series.name); limit != values.end())
        if (auto a = alarm(series, last.values, last.covariance.diagonal(), limit->second)) found.push_back(*a);
      const auto limit = changes.find(series.name);
      if (limit == changes.end() || series.points.size() < 2) continue;
      if (auto a = alarm(series, last.values - first.values, last.covariance.diagonal() + first.covariance.diagonal(),
                         limit->second)) {
        a->of_change = true;
        found.push_back(*a);
      }
    }
  return found;
}

}  // namespace trunnion
