#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace trunnion {

/// The name of the program with its version: "trunnion 0.1.0".
std::string program_version();

/// What made a result, to be merged into its JSON: {"program": "trunnion 0.1.0", "inputs_sha256": {NAME: digits}}, the
/// inputs by their file names without folders; null for what is no file and was read once (a pipe).
nlohmann::json provenance_json(const std::vector<std::string>& inputs);

}  // namespace trunnion
