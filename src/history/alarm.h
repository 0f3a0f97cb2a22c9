#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "history/error_series.h"

namespace trunnion {

/// An error beyond its limit in the last calibration.
struct Alarm {
  std::string error;
  Unit unit = Unit::um;
  bool of_change = false;                ///< since the first calibration; else its value
  double found = 0, std = 0, limit = 0;  ///< in `unit`
  bool proven = false;                   ///< beyond by more than two standard uncertainties
  std::optional<IndexedPosition> at;     ///< where it is largest, for a function
};

/// Limits in the error's own unit, by the names of locations, functions and parameters of `set`. A function is beyond
/// its limit where any of its positions is; the largest is told.
std::vector<Alarm> find_alarms(const SeriesSet& set, const std::map<std::string, double>& values,
                               const std::map<std::string, double>& changes);

}  // namespace trunnion
