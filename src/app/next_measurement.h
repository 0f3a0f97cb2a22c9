#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "discovery/closure.h"
#include "kinematics/machine.h"

namespace trunnion {

/// The touches that would tell an accepted effect from what these data cannot tell it from.
struct NextMeasurement {
  /// One visit, as the axes come to it.
  struct Stop {
    double tilt_deg = 0, turn_deg = 0;
    int tilt_sense = 0, turn_sense = 0;
    std::vector<std::string> points;
  };
  struct Seen {
    std::string effect, parameter, unit;
    double before = 0, after = 0;  ///< smallest size found nine times in ten, in `unit`; infinite: cannot be seen
  };

  std::string effect;
  std::string file;                ///< where the rows are written: next.csv, next_2.csv …
  std::vector<std::string> apart;  ///< what `trunnion plan --separate` was asked, one id or two
  std::string rows;                ///< an observations file with nominal places, as `plan` writes
  std::vector<Stop> stops;
  std::vector<Seen> seen;
  char tilt_letter = 'A';

  nlohmann::json json() const;  ///< {"separate", "file", "rows": [...], "power": [...]}
  std::string text() const;     ///< a line a visit
};

/// For each accepted effect that shares its evidence with another, three visits after those of `so_far`. None where
/// nothing was touched, and none for an effect that no touch can show.
std::vector<NextMeasurement> next_measurements(const ClosureResult& result, const ObservationSet& so_far,
                                               const Machine& machine);

}  // namespace trunnion
