#pragma once

#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "model/effect.h"

namespace trunnion {

/// An effect that is no more than its formula: what most of the catalogue is.
struct Formula {
  std::string id;
  Origin origin = Origin::machine;
  bool moves_table = false;
  std::vector<std::string> depends_on;
  std::vector<Parameter> parameters;
  std::vector<Parameter> shape;
  std::vector<ShapeRange> shape_ranges;     ///< one for each number of the shape
  std::map<std::string, std::string> keys;  ///< texts written beside the id, such as the column that drives it
  /// B(situation), 6 x parameters, for a shape (inside units).
  std::function<Matrix6Xd(const Situation&, const Eigen::VectorXd& shape)> basis;
};

/// The effect of a formula, with the values that its parameters carry.
EffectPtr make_effect(Formula formula);

/// The same with shape, values and covariance from what to_json wrote. Throws ModelError naming the key.
EffectPtr make_effect(Formula formula, const nlohmann::json& json);

/// The text under `key` of a model's entry. Throws ModelError if it is missing.
std::string text_key(const nlohmann::json& json, const std::string& key, const std::string& effect);

/// Throws the ModelError for a detail that a family does not have: "effect straightness:EQX: one of … is wanted".
[[noreturn]] void refuse_detail(const std::string& family, const std::string& detail, const std::string& wanted);

/// Columns `factor` x the unit translations (rotations) along X, Y, Z: 6 x 3.
Matrix6Xd translations(double factor);
Matrix6Xd rotations(double factor);

}  // namespace trunnion
