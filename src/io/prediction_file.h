#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "testpiece/prediction_spread.h"
#include "testpiece/sensitivity.h"

namespace trunnion {

/// One way in which the piece was cut, and what was found on it.
struct PredictedPiece {
  std::vector<double> deviation_mm;  ///< one per evaluated point
  ConeEvaluation evaluation;
  std::optional<PredictionSpread> spread;
};

/// `DIR/deviations.csv`: the deviations that were asked for; where that is not the uncompensated piece, its deviations
/// as uncompensated_um beside them; sd_um where the model knows its uncertainty.
std::string deviations_text(const SurfaceGrid& surface, const PredictedPiece& asked,
                            const PredictedPiece* uncompensated);

/// One piece of `DIR/prediction.json`. Beside CONTRACT's keys: spreads as NAME_sd and NAME_95 = [low, high], the axis'
/// tilt as a vector, concentricity, conicity, the largest deviation, undulations 2 to 8 of each height.
nlohmann::json evaluation_json(const TestPiece& piece, const SurfaceGrid& surface, const PredictedPiece& predicted);
/// The same for measured traces.
nlohmann::json evaluation_json(const ConeEvaluation& evaluation);

/// `DIR/sensitivity.json` and the same as a table for people.
nlohmann::json sensitivity_json(const std::vector<Sensitivity>& found, const BetterPiece& better);
std::string sensitivity_text(const std::vector<Sensitivity>& found, const BetterPiece& better);

}  // namespace trunnion
