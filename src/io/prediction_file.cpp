#include "io/prediction_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "io/csv.h"
#include "testpiece/profile_filter.h"

namespace trunnion {
namespace {

using nlohmann::json;

constexpr int kHighestUndulation = 8;

void put(json& j, const std::string& name, const DrawnSpread& spread, double unit) {
  j[name + "_sd"] = spread.sd / unit;
  j[name + "_95"] = {spread.low / unit, spread.high / unit};
}

std::string fixed(double value, int width, int decimals) {
  char text[64];
  const int length = std::snprintf(text, sizeof text, "%*.*f", width, decimals, value);
  return {text, static_cast<std::size_t>(std::clamp(length, 0, 63))};
}

std::string padded(std::string text, std::size_t width) {
  text.resize(std::max(width, text.size()), ' ');
  return text;
}

}  // namespace

std::string deviations_text(const SurfaceGrid& surface, const PredictedPiece& asked,
                            const PredictedPiece* uncompensated) {
  std::string text = "phi_deg,h_mm,x_mm,y_mm,z_mm,nx,ny,nz,deviation_um";
  if (uncompensated != nullptr) text += ",uncompensated_um";
  if (asked.spread) text += ",sd_um";
  text += '\n';
  const std::size_t n = surface.phi_rad.size();
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    const ConePoint& on = surface.points[i];
    append_number(text, 360.0 * static_cast<double>(i % n) / static_cast<double>(n));
    const auto append = [&](double value) {
      text += ',';
      append_number(text, value);
    };
    append(surface.h_mm[i / n]);
    for (const double v : on.point_w_mm) append(v);
    for (const double v : on.normal_w) append(v);
    append(1e3 * asked.deviation_mm[i]);
    if (uncompensated != nullptr) append(1e3 * uncompensated->deviation_mm[i]);
    if (asked.spread) append(1e3 * asked.spread->deviation_sd_mm[i]);
    text += '\n';
  }
  return text;
}

json evaluation_json(const ConeEvaluation& evaluation) {
  json heights = json::array();
  for (const HeightEvaluation& at : evaluation.heights)
    heights.push_back({{"h_mm", at.h_mm},
                       {"lsc_um", 1e3 * at.lsc_mm},
                       {"mzc_um", 1e3 * at.mzc_mm},
                       {"mic_um", 1e3 * at.mic_mm},
                       {"mcc_um", 1e3 * at.mcc_mm},
                       {"center_um", {1e3 * at.center_mm.x(), 1e3 * at.center_mm.y()}},
                       {"diameter_mm", at.diameter_mm}});
  json j = {{"heights", std::move(heights)}, {"half_angle_deg", nullptr}, {"axis_tilt_urad", nullptr}};
  j["rms_um"] = 1e3 * evaluation.rms_mm;
  if (evaluation.half_angle) {
    j["half_angle_deg"] = evaluation.half_angle->in_degrees();
    j["axis_tilt_urad"] = 1e6 * evaluation.axis_tilt_rad->norm();
    j["axis_tilt_xy_urad"] = {1e6 * evaluation.axis_tilt_rad->x(), 1e6 * evaluation.axis_tilt_rad->y()};
    j["concentricity_um"] = 1e3 * *evaluation.concentricity_mm;
    j["conicity_um"] = 1e3 * *evaluation.conicity_mm;
  }
  return j;
}

json evaluation_json(const TestPiece& piece, const SurfaceGrid& surface, const PredictedPiece& predicted) {
  json j = evaluation_json(predicted.evaluation);
  double largest = 0;
  for (const double d : predicted.deviation_mm) largest = std::max(largest, std::abs(d));
  j["max_um"] = 1e3 * largest;
  const std::vector<ConeTrace> traces = traces_of(piece, surface, predicted.deviation_mm);
  const int highest = std::min(kHighestUndulation, (piece.points - 1) / 2);
  for (std::size_t i = 0; i < traces.size(); ++i) {
    json waves = json::array();
    for (const Undulation& u : undulations(radial_trace(traces[i], piece.cone.half_angle), highest))
      if (u.per_turn >= 2) waves.push_back({{"per_turn", u.per_turn}, {"amplitude_um", 1e3 * u.amplitude_mm}});
    j["heights"][i]["undulations"] = std::move(waves);
  }
  if (!predicted.spread) return j;
  const PredictionSpread& spread = *predicted.spread;
  for (std::size_t i = 0; i < spread.heights.size(); ++i) {
    json& height = j["heights"][i];
    const HeightSpread& at = spread.heights[i];
    put(height, "lsc_um", at.lsc_mm, 1e-3);
    put(height, "mzc_um", at.mzc_mm, 1e-3);
    put(height, "mic_um", at.mic_mm, 1e-3);
    put(height, "mcc_um", at.mcc_mm, 1e-3);
    put(height, "diameter_mm", at.diameter_mm, 1);
    height["center_um_sd"] = {1e3 * at.center_x_mm.sd, 1e3 * at.center_y_mm.sd};
  }
  if (spread.half_angle_rad) {
    put(j, "half_angle_deg", *spread.half_angle_rad, Angle::degrees(1).in_radians());
    put(j, "axis_tilt_urad", *spread.axis_tilt_rad, 1e-6);
  }
  put(j, "rms_um", spread.rms_mm, 1e-3);
  return j;
}

json sensitivity_json(const std::vector<Sensitivity>& found, const BetterPiece& better) {
  json rows = json::array();
  for (const Sensitivity& s : found) {
    json row = evaluation_json(s.shown);
    row["error"] = s.error;
    row["amount"] = s.amount;
    row["unit"] = unit_text(s.unit).text;
    row["size_um"] = 1e3 * s.size_mm;
    row["seen_in_roundness"] = s.seen_in_roundness;
    rows.push_back(std::move(row));
  }
  const ConeFrustum& cone = better.piece.cone;
  return {{"errors", std::move(rows)},
          {"never_in_roundness", better.never},
          {"better_piece",
           {{"half_angle_deg", cone.half_angle.in_degrees()},
            {"tilt_deg", cone.tilt.in_degrees()},
            {"base_center_mm", {cone.base_center_w_mm.x(), cone.base_center_w_mm.y(), cone.base_center_w_mm.z()}},
            {"least_seen_um", 1e3 * better.least_seen_mm},
            {"least_seen_here_um", 1e3 * better.least_seen_here_mm}}}};
}

std::string sensitivity_text(const std::vector<Sensitivity>& found, const BetterPiece& better) {
  std::string text =
      padded("error", 12) + "    amount       LSC by height, um          centre um   size um  tilt urad\n";
  for (const Sensitivity& s : found) {
    text += padded(s.error, 12) + fixed(s.amount, 6, 0) + " " + padded(std::string(unit_text(s.unit).text), 5);
    std::string roundness;
    for (const HeightEvaluation& at : s.shown.heights) roundness += fixed(1e3 * at.lsc_mm, 8, 2);
    text += padded(roundness, 28) + fixed(1e3 * s.shown.heights.front().center_mm.norm(), 9, 2) +
            fixed(1e3 * s.size_mm, 10, 2) +
            (s.shown.axis_tilt_rad ? fixed(1e6 * s.shown.axis_tilt_rad->norm(), 11, 1) : "") +
            (s.seen_in_roundness ? "" : "   not seen in roundness") + "\n";
  }
  const ConeFrustum& cone = better.piece.cone;
  text += "A half angle of " + fixed(cone.half_angle.in_degrees(), 0, 0) + " deg, a tilt of " +
          fixed(cone.tilt.in_degrees(), 0, 0) + " deg and a base " + fixed(cone.base_center_w_mm.z(), 0, 0) +
          " mm high show the least visible location error at " + fixed(1e3 * better.least_seen_mm, 0, 2) +
          " um (this piece: " + fixed(1e3 * better.least_seen_here_mm, 0, 2) + " um).\n";
  if (!better.never.empty()) {
    text += "No cone shows in its roundness:";
    for (const std::string& name : better.never) text += " " + name;
    text += "\n";
  }
  return text;
}

}  // namespace trunnion
