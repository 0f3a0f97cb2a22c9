#include "app/prediction_text.h"

#include "app/text_table.h"

namespace trunnion {
namespace {

using Rows = std::vector<std::vector<std::string>>;

void add_heights(Rows& rows, const std::string& name, const ConeEvaluation& evaluation,
                 const PredictionSpread* spread) {
  for (std::size_t j = 0; j < evaluation.heights.size(); ++j) {
    const HeightEvaluation& at = evaluation.heights[j];
    const auto roundness = [&](double value_mm, DrawnSpread HeightSpread::*of) {
      return spread != nullptr ? with_uncertainty(1e3 * value_mm, 1e3 * (spread->heights[j].*of).sd)
                               : formatted("%.3f", 1e3 * value_mm);
    };
    rows.push_back({j == 0 ? name : "", formatted("%g", at.h_mm), roundness(at.lsc_mm, &HeightSpread::lsc_mm),
                    roundness(at.mzc_mm, &HeightSpread::mzc_mm), roundness(at.mic_mm, &HeightSpread::mic_mm),
                    roundness(at.mcc_mm, &HeightSpread::mcc_mm), formatted("%.2f", 1e3 * at.center_mm.norm()),
                    formatted("%.5f", at.diameter_mm)});
  }
}

std::vector<std::string> whole_piece(const std::string& name, const ConeEvaluation& evaluation) {
  std::vector<std::string> row = {name, formatted("%.3f", 1e3 * evaluation.rms_mm),
                                  formatted("%.3f", 1e3 * evaluation.form_mm)};
  if (evaluation.half_angle) {
    row.push_back(formatted("%.6f", evaluation.half_angle->in_degrees()));
    row.push_back(formatted("%.1f", 1e6 * evaluation.axis_tilt_rad->norm()));
    row.push_back(formatted("%.3f", 1e3 * *evaluation.concentricity_mm));
  }
  return row;
}

std::string percent(const std::optional<double>& share) { return share ? formatted("%.1f", 100 * *share) : "-"; }

}  // namespace

std::string prediction_text(const TestPiece& piece, std::span<const PredictedPiece> pieces,
                            const std::optional<ConeEvaluation>& measured) {
  Rows heights = {{"", "h mm", "LSC um", "MZC um", "MIC um", "MCC um", "centre um", "diameter mm"}};
  Rows whole = {{"", "rms um", "form um", "half angle deg", "axis tilt urad", "concentricity um"}};
  Rows removed = {{"error removed, %", "rms", "roundness", "form", "position", "size"}};
  for (const PredictedPiece& p : pieces) {
    add_heights(heights, p.name, p.evaluation, p.spread ? &*p.spread : nullptr);
    whole.push_back(whole_piece(p.name, p.evaluation));
    if (&p == pieces.data()) continue;
    const RemovedShares share = removed_shares(piece, pieces.front().evaluation, p.evaluation);
    removed.push_back({p.name, percent(share.rms), percent(share.roundness), percent(share.form),
                       percent(share.position), percent(share.size)});
  }
  if (measured) {
    add_heights(heights, "measured", *measured, nullptr);
    whole.push_back(whole_piece("measured", *measured));
  }
  std::string text = text_table(heights) + text_table(whole);
  if (removed.size() > 1) text += text_table(removed);
  return text;
}

}  // namespace trunnion
