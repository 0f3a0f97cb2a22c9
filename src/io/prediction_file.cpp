#include "io/prediction_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "io/csv.h"
#include "testpiece/profile_filter.h"
#include "units/number_text.h"

namespace trunnion {
namespace {

using nlohmann::json;

constexpr int kHighestUndulation = 8;

void put(json& j, const std::string& name, const DrawnSpread& spread, double unit) {
  j[name + "_sd"] = spread.sd / unit;
  j[name + "_95"] = {spread.low / unit, spread.high / unit};
}

std::string fixed(double value, int width, int decimals) {
  const double least = 0.5 * std::pow(10.0, -decimals);  // what rounds to nothing has no sign
  return printed("%*.*f", width, decimals, std::abs(value) < least ? 0.0 : value);
}

std::string padded(std::string text, std::size_t width) {
  text.resize(std::max(width, text.size()), ' ');
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
  j["form_um"] = 1e3 * evaluation.form_mm;
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

/// What a line says where the roundness does not show it.
std::string seen_text(const Sensitivity& s) {
  if (s.seen_in_roundness()) return "";
  if (s.seen_in.empty()) return "   not seen";
  std::string text;
  for (const std::string& in : s.seen_in) text += (text.empty() ? "   only in " : ", ") + in;
  return text;
}

}  // namespace

std::string deviations_text(const SurfaceGrid& surface, std::span<const PredictedPiece> pieces, std::size_t asked) {
  std::string text = "phi_deg,h_mm,x_mm,y_mm,z_mm,nx,ny,nz,deviation_um";
  for (std::size_t k = 0; k < pieces.size(); ++k)
    if (k != asked) text += "," + pieces[k].name + "_um";
  const bool uncertain = pieces[asked].spread.has_value();
  if (uncertain) text += ",sd_um";
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
    append(1e3 * pieces[asked].deviation_mm[i]);
    for (std::size_t k = 0; k < pieces.size(); ++k)
      if (k != asked) append(1e3 * pieces[k].deviation_mm[i]);
    if (uncertain) append(1e3 * pieces[asked].spread->deviation_sd_mm[i]);
    text += '\n';
  }
  return text;
}

std::string flank_text(const SurfaceGrid& surface, std::span<const CutFlank> cuts) {
  std::string text = "phi_deg,h_mm";
  for (const CutFlank& cut : cuts) text += "," + cut.name + "_um";
  text += '\n';
  const std::size_t n = surface.phi_rad.size();
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    append_number(text, 360.0 * static_cast<double>(i % n) / static_cast<double>(n));
    text += ',';
    append_number(text, surface.h_mm[i / n]);
    for (const CutFlank& cut : cuts) {
      text += ',';
      append_number(text, 1e3 * cut.deviation_mm[i]);
    }
    text += '\n';
  }
  return text;
}

json piece_json(const TestPiece& piece) {
  const ConeFrustum& cone = piece.cone;
  return {
      {"kind", "cone_frustum"},
      {"half_angle_deg", cone.half_angle.in_degrees()},
      {"base_diameter_mm", cone.base_diameter.in_millimetres()},
      {"height_mm", cone.height.in_millimetres()},
      {"base_center_mm", {cone.base_center_w_mm.x(), cone.base_center_w_mm.y(), cone.base_center_w_mm.z()}},
      {"tilt_deg", cone.tilt.in_degrees()},
      {"tilt_azimuth_deg", cone.tilt_azimuth.in_degrees()},
      {"tool",
       {{"diameter_mm", piece.tool.diameter.in_millimetres()}, {"overhang_mm", piece.tool.overhang.in_millimetres()}}},
      {"path", {{"sense", piece.sense}}}};
}

RemovedShares removed_shares(const TestPiece& piece, const ConeEvaluation& before, const ConeEvaluation& after) {
  constexpr double kNothing_mm = 1e-9;
  const auto share = [](double from, double to) {
    return from > kNothing_mm ? std::optional<double>(1 - to / from) : std::nullopt;
  };
  const auto worst = [](const ConeEvaluation& e, auto value) {
    double most = 0;
    for (const HeightEvaluation& at : e.heights) most = std::max(most, value(at));
    return most;
  };
  const auto removed = [&](auto value) { return share(worst(before, value), worst(after, value)); };
  return {.rms = share(before.rms_mm, after.rms_mm),
          .roundness = removed([](const HeightEvaluation& at) { return at.lsc_mm; }),
          .form = share(before.form_mm, after.form_mm),
          .position = removed([](const HeightEvaluation& at) { return at.center_mm.norm(); }),
          .size = removed([&](const HeightEvaluation& at) {
            const Length nominal = 2 * radius_at(piece.cone, Length::millimetres(at.h_mm));
            return std::abs(at.diameter_mm - nominal.in_millimetres());
          })};
}

json removed_json(const RemovedShares& removed) {
  json j;
  const auto put_share = [&](const char* name, const std::optional<double>& share) {
    j[name] = share ? json(*share) : json(nullptr);
  };
  put_share("rms", removed.rms);
  put_share("roundness", removed.roundness);
  put_share("form", removed.form);
  put_share("position", removed.position);
  put_share("size", removed.size);
  return j;
}

json evaluation_json(const TestPiece& piece, std::span<const ConeTrace> traces, const ConeEvaluation& evaluation) {
  json j = evaluation_json(evaluation);
  double largest = 0;
  for (const ConeTrace& trace : traces)
    for (const double d : trace.normal_mm) largest = std::max(largest, std::abs(d));
  j["max_um"] = 1e3 * largest;
  for (std::size_t i = 0; i < traces.size(); ++i) {
    const int highest = std::min(kHighestUndulation, (static_cast<int>(traces[i].phi_rad.size()) - 1) / 2);
    json waves = json::array();
    for (const Undulation& u : undulations(radial_trace(traces[i], piece.cone.half_angle), highest))
      if (u.per_turn >= 2) waves.push_back({{"per_turn", u.per_turn}, {"amplitude_um", 1e3 * u.amplitude_mm}});
    j["heights"][i]["undulations"] = std::move(waves);
  }
  return j;
}

json evaluation_json(const TestPiece& piece, const SurfaceGrid& surface, const PredictedPiece& predicted) {
  json j = evaluation_json(piece, traces_of(piece, surface, predicted.deviation_mm), predicted.evaluation);
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
  put(j, "form_um", spread.form_mm, 1e-3);
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
    row["seen_in"] = s.seen_in;
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
      padded("error", 18) + "    amount       LSC by height, um          centre um   size um  tilt urad\n";
  for (const Sensitivity& s : found) {
    text += padded(s.error, 18) + fixed(s.amount, 6, 0) + " " + padded(std::string(unit_text(s.unit).text), 5);
    std::string roundness;
    for (const HeightEvaluation& at : s.shown.heights) roundness += fixed(1e3 * at.lsc_mm, 8, 2);
    text += padded(roundness, 28) + fixed(1e3 * s.shown.heights.front().center_mm.norm(), 9, 2) +
            fixed(1e3 * s.size_mm, 10, 2) +
            (s.shown.axis_tilt_rad ? fixed(1e6 * s.shown.axis_tilt_rad->norm(), 11, 1) : "") + "   " + seen_text(s) +
            "\n";
  }
  text += "Size: of the cone, or its place along its axis. The part's place and axis are its set-up.\n";
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
