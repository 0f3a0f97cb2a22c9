#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace trunnion {

/// The finite number that stands at `where` of a model file. @throws ModelError naming `where` and what was found
double number(const nlohmann::json& j, const std::string& where);

/// What an object at `where` holds under `key`. @throws ModelError naming `where` and the key that is missing
const nlohmann::json& member(const nlohmann::json& j, const char* key, const std::string& where);

}  // namespace trunnion
