#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "model/model.h"
#include "probing/observation.h"

namespace trunnion {

/// Least and largest value of each covariate that was observed: time_s, temperature_C and further columns, in the units
/// of their names. Beyond them an effect is held at the end (CONTRACT: Model).
using ObservedRanges = std::map<std::string, Range<double>>;

/// Those of a set of observations.
ObservedRanges observed_ranges(const ObservationSet& set);

/// As a model's "fit" carries them: {"time_s": [low, high], …} under the key "observed".
nlohmann::json observed_json(const ObservationSet& set);

/// Those of a model; empty where it does not say. Throws ModelError for what is no [low, high].
ObservedRanges observed_ranges(const Model& model);

/// `value` of `column`, held at the end of its observed range; unchanged where that is not known.
double held(const ObservedRanges& ranges, const std::string& column, double value);

}  // namespace trunnion
