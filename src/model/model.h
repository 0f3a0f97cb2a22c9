#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "model/catalogue.h"

namespace trunnion {

/// Whose model it is.
struct MachineIdentity {
  std::string name;
  std::string serial;
  std::string structure;
  friend bool operator==(const MachineIdentity&, const MachineIdentity&) = default;
};

/// A model is a list of effects; pose error and deviation are their sums. A plain value.
struct Model {
  MachineIdentity machine;
  std::vector<EffectPtr> effects;
  std::shared_ptr<const nlohmann::json> fit;  ///< how it was found; carried along, never interpreted here

  /// The rotary error map, if the model holds one; else nullptr.
  const class RotaryErrorMap* rotary_map() const;
  bool has_uncertainty() const;
};

/// The context in which a machine's effects live.
EffectContext effect_context(const Machine& machine);

/// The table's pose error Delta: the machine's effects that move the table as a whole, at R's origin.
PoseError table_error(const Model& model, const Situation& situation);

/// The error of the workpiece relative to the tool, of all effects of the machine (never the measurement's).
PoseError relative_error(const Model& model, const Situation& situation);

/// The deviation d = T(relative_error) p - p at the situation's point: what must be added to the commanded position so
/// that the tool meets the workpiece where it nominally should. mm, in R.
Eigen::Vector3d deviation_mm(const Model& model, const Situation& situation);

/// Its covariance, mm^2; effects are taken as independent of one another.
Eigen::Matrix3d deviation_covariance_mm2(const Model& model, const Situation& situation);

/// Covariates, beyond position and direction of approach, that effects of the machine need: time_s, A_dir, extra
/// columns …
std::vector<std::string> needed_covariates(const Model& model);

}  // namespace trunnion
