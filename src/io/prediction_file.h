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
  std::string name;                  ///< as in prediction.json: uncompensated, tables, corrected, ideal
  std::vector<double> deviation_mm;  ///< one per evaluated point
  ConeEvaluation evaluation;
  std::optional<PredictionSpread> spread;
};

/// What a compensation took away of the piece's errors, 0 … 1, each empty where there was nothing to take: root mean
/// square, roundness (LSC, the worst height), form, distance of the worst centre from the nominal axis, error of the
/// worst diameter.
struct RemovedShares {
  std::optional<double> rms, roundness, form, position, size;
};
RemovedShares removed_shares(const TestPiece& piece, const ConeEvaluation& before, const ConeEvaluation& after);

/// `DIR/deviations.csv`: as deviation_um the deviations of `pieces[asked]`, those of the others as NAME_um beside them;
/// sd_um where the model knows its uncertainty.
std::string deviations_text(const SurfaceGrid& surface, std::span<const PredictedPiece> pieces, std::size_t asked);

/// The whole flank as one way of cutting leaves it: deviation_mm[i_height * phi + k].
struct CutFlank {
  std::string name;
  std::vector<double> deviation_mm;
};

/// `DIR/flank.csv`: phi_deg, h_mm and NAME_um of every way of cutting, over the whole flank.
std::string flank_text(const SurfaceGrid& surface, std::span<const CutFlank> cuts);

/// The piece as `DIR/prediction.json` carries it, by the keys of its own file.
nlohmann::json piece_json(const TestPiece& piece);

/// One piece of `DIR/prediction.json`. Beside CONTRACT's keys: spreads as NAME_sd and NAME_95 = [low, high], the axis'
/// tilt as a vector, concentricity, conicity, form, the largest deviation, undulations 2 to 8 of each height.
nlohmann::json evaluation_json(const TestPiece& piece, const SurfaceGrid& surface, const PredictedPiece& predicted);
/// The same for traces that were measured.
nlohmann::json evaluation_json(const TestPiece& piece, std::span<const ConeTrace> traces,
                               const ConeEvaluation& evaluation);
nlohmann::json removed_json(const RemovedShares& removed);

/// `DIR/sensitivity.json` and the same as a table for people.
nlohmann::json sensitivity_json(const std::vector<Sensitivity>& found, const BetterPiece& better);
std::string sensitivity_text(const std::vector<Sensitivity>& found, const BetterPiece& better);

}  // namespace trunnion
