#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "identification/identify.h"

namespace trunnion {

/// How a model was found, as the "fit" of its file and as the summary of `identify --json`: counts, rank, noise against
/// declaration, outliers by line, freedoms that were not seen, location errors, every error against zero, evidence for
/// the interpolation, hashes of the input files. Lengths um, angles urad, positions deg.
nlohmann::json identification_json(const IdentificationResult& result, const Machine& machine,
                                   const std::vector<std::string>& inputs);

}  // namespace trunnion
