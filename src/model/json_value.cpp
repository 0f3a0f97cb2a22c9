#include "model/json_value.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "error.h"

namespace trunnion {

using nlohmann::json;

double number(const json& j, const std::string& where) {
  if (!j.is_number()) throw ModelError(where + ": " + j.dump() + " found, a number is wanted");
  const double value = j.get<double>();
  if (!std::isfinite(value)) throw ModelError(where + ": " + j.dump() + " found, a finite number is wanted");
  return value;
}

const json& member(const json& j, const char* key, const std::string& where) {
  if (!j.is_object() || !j.contains(key)) throw ModelError(where + ": \"" + key + "\" is missing");
  return j[key];
}

}  // namespace trunnion
