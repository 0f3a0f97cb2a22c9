#pragma once

#include <optional>
#include <string>
#include <vector>

#include "identification/identify.h"

namespace trunnion {

/// An earlier model as `identify` takes it, and what of it is not used, in sentences for people.
struct PriorMap {
  EarlierMap earlier;
  std::vector<std::string> notes;
};

/// The map of `model` and how far the machine may have moved since, 1 sigma: as told, else as the model's file says.
/// `name` stands for the model in messages. Throws UsageError where neither says the drift, InputError for a model
/// without a map.
PriorMap prior_map(const Model& model, const std::string& name, std::optional<double> drift_um,
                   std::optional<double> drift_urad);

}  // namespace trunnion
