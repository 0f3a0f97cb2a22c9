#include "io/observed_ranges.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "error.h"

namespace trunnion {

ObservedRanges observed_ranges(const ObservationSet& set) {
  ObservedRanges ranges;
  const auto see = [&](const std::string& column, double value) {
    const auto [range, first] = ranges.try_emplace(column, Range<double>{value, value});
    if (!first) range->second = {std::min(range->second.low, value), std::max(range->second.high, value)};
  };
  for (const Observation& row : set.rows) {
    if (set.has_time) see("time_s", row.time_s);
    if (set.has_temperature) see("temperature_C", row.temperature_C);
  }
  const std::size_t columns = set.extra_columns.size();
  for (std::size_t k = 0; k < set.extra_values.size(); ++k) see(set.extra_columns[k % columns], set.extra_values[k]);
  return ranges;
}

nlohmann::json observed_json(const ObservationSet& set) {
  nlohmann::json json = nlohmann::json::object();
  for (const auto& [column, range] : observed_ranges(set)) json[column] = {range.low, range.high};
  return json;
}

ObservedRanges observed_ranges(const Model& model) {
  ObservedRanges ranges;
  if (!model.fit || !model.fit->is_object() || !model.fit->contains("observed")) return ranges;
  const nlohmann::json& observed = (*model.fit)["observed"];
  if (!observed.is_object()) throw ModelError("fit.observed: " + observed.dump() + " found, an object is wanted");
  for (const auto& [column, range] : observed.items()) {
    if (!range.is_array() || range.size() != 2 || !range[0].is_number() || !range[1].is_number() ||
        !(range[0].get<double>() <= range[1].get<double>()))
      throw ModelError("fit.observed." + column + ": " + range.dump() + " found, [low, high] is wanted");
    ranges[column] = {range[0].get<double>(), range[1].get<double>()};
  }
  return ranges;
}

double held(const ObservedRanges& ranges, const std::string& column, double value) {
  const auto range = ranges.find(column);
  return range == ranges.end() ? value : std::clamp(value, range->second.low, range->second.high);
}

}  // namespace trunnion
