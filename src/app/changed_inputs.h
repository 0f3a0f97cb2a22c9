#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "model/model.h"

namespace trunnion {

/// Files that are not what a result was made from: a line each, with both hashes. `provenance` is an object that holds
/// `inputs_sha256`, as results do; `result` names it in the lines. A file counts as an input by its name.
std::vector<std::string> changed_inputs(const nlohmann::json& provenance, const std::string& result,
                                        const std::vector<std::string>& files);

/// The same for a model file.
std::vector<std::string> changed_inputs(const Model& model, const std::string& result,
                                        const std::vector<std::string>& files);

/// The same for a compensation: a model file of `machine`, or a folder of tables.
std::vector<std::string> changed_compensation(const std::string& path, const Machine& machine,
                                              const std::vector<std::string>& files);

/// The same for a folder that `trunnion tables` wrote, and for its own files since they were verified. Nothing for what
/// is no such folder.
std::vector<std::string> changed_since_verified(const std::string& folder, const std::vector<std::string>& files);

}  // namespace trunnion
