#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "discovery/closure.h"

namespace trunnion {

/// The content of closure.json (CONTRACT: Closure).
nlohmann::json closure_json(const ClosureResult& result);

/// The residual of every reading before and after, with all its covariates, ready to plot (CSV): where it was taken,
/// when, of what, whether it was kept back or left out.
std::string residual_csv(const ClosureResult& result, char tilt_letter);

}  // namespace trunnion
