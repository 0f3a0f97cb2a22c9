#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "report/chart.h"
#include "report/html.h"
#include "report/sections.h"
#include "units/number_text.h"

namespace trunnion {
namespace {

using nlohmann::json;

constexpr double kCoverage = 2;  ///< standard uncertainties of a band on either side, about 95 %

const json* map_of(const json& model) {
  if (!model.contains("effects") || !model["effects"].is_array()) return nullptr;
  for (const json& effect : model["effects"])
    if (text_at(effect, "id") == "rotary_error_map" && effect.contains("grid_deg") && effect.contains("values"))
      return &effect;
  return nullptr;
}

/// The model that the readings gave; else the first.
const ResultFile* identified(const Evidence& evidence) {
  const ResultFile* found = nullptr;
  for (const ResultFile& r : evidence.results) {
    if (r.kind != ResultKind::model) continue;
    if (r.content->contains("fit") && (*r.content)["fit"].contains("errors")) return &r;
    if (found == nullptr && map_of(*r.content) != nullptr) found = &r;
  }
  return found;
}

std::vector<double> list(const json& values) {
  std::vector<double> numbers;
  if (values.is_array())
    for (const json& v : values) numbers.push_back(v.is_number() ? v.get<double>() : std::nan(""));
  return numbers;
}

const json* under(const json& j, const std::string& part, const std::string& symbol) {
  if (!j.contains(part) || !j[part].contains(symbol) || !j[part][symbol].contains("data")) return nullptr;
  return &j[part][symbol]["data"];
}

/// The errors of one axis with one unit as functions of the tilt.
Chart tilt_chart(const json& map, char tilt, const std::string& letters, bool angular) {
  Chart chart{.title = std::string(angular ? "Angular" : "Linear") + " errors of " + tilt,
              .x_label = std::string("commanded ") + tilt + ", deg",
              .y_label = angular ? "error, µrad" : "error, µm",
              .x_name = std::string(1, tilt),
              .y_unit = angular ? "µrad" : "µm",
              .x = list(map["grid_deg"][std::string(1, tilt)]),
              .series = {},
              .note = "Band: ± 2 standard uncertainties (about 95 %) at the measured angles."};
  for (const char letter : letters) {
    const std::string symbol = std::string("E") + letter + tilt;
    const json* values = under(map, "values", symbol);
    if (values == nullptr) continue;
    ChartSeries series{symbol, list(*values)};
    if (const json* std = under(map, "std", symbol))
      for (const double s : list(*std)) series.half_width.push_back(kCoverage * s);
    if (series.values.size() == chart.x.size()) chart.series.push_back(std::move(series));
  }
  return chart;
}

/// One error of C as a function of C at every tilt, closed over the turn.
Chart turn_chart(const json& map, char tilt, const std::string& symbol, bool angular) {
  const std::vector<double> tilts = list(map["grid_deg"][std::string(1, tilt)]);
  Chart chart{.title = symbol,
              .x_label = "commanded C, deg",
              .y_label = angular ? "error, µrad" : "error, µm",
              .x_name = "C",
              .y_unit = angular ? "µrad" : "µm",
              .x = list(map["grid_deg"]["C"]),
              .series = {}};
  const bool closed = chart.x.size() > 2 && chart.x.back() < chart.x.front() + 360;
  if (closed) chart.x.push_back(chart.x.front() + 360);
  const json* values = under(map, "values", symbol);
  const json* std = under(map, "std", symbol);
  if (values == nullptr || !values->is_array()) return chart;
  for (std::size_t i = 0; i < std::min(tilts.size(), values->size()); ++i) {
    ChartSeries series{std::string(1, tilt) + " " + quantity(tilts[i], std::nullopt, "") + "°", list((*values)[i])};
    if (std != nullptr && i < std->size())
      for (const double s : list((*std)[i])) series.half_width.push_back(kCoverage * s);
    if (closed && !series.values.empty()) series.values.push_back(series.values.front());
    if (closed && !series.half_width.empty()) series.half_width.push_back(series.half_width.front());
    const bool whole = series.values.size() == chart.x.size() &&
                       (series.half_width.empty() || series.half_width.size() == chart.x.size());
    if (whole) chart.series.push_back(std::move(series));
  }
  return chart;
}

std::string map_charts(const json& map) {
  const char tilt = map["grid_deg"].contains("B") ? 'B' : 'A';
  if (!map["grid_deg"].contains(std::string(1, tilt)) || !map["grid_deg"].contains("C")) return "";
  std::string figures;
  for (const auto& [letters, angular] : {std::pair("XYZ", false), std::pair("ABC", true)})
    if (const Chart chart = tilt_chart(map, tilt, letters, angular); !chart.series.empty())
      figures += chart_figure(chart);
  for (const char letter : std::string("XYZABC"))
    if (const Chart chart = turn_chart(map, tilt, std::string("E") + letter + "C", letter < 'X'); !chart.series.empty())
      figures += chart_figure(chart);
  return element("div", figures, "class=\"charts\"");
}

std::string position(const json& at) {
  std::string text;
  if (at.is_object())
    for (const auto& [key, value] : at.items())
      if (value.is_number())
        text += (text.empty() ? "" : ", ") + key.substr(0, 1) + "\u00a0" +
                quantity(value.get<double>(), std::nullopt, "") + "°";
  return text;
}

std::string error_table(const json& fit) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& [symbol, e] : fit["errors"].items()) {
    const double nodes = number_at(e, {"nodes"}).value_or(0), unseen = number_at(e, {"nodes_unseen"}).value_or(0);
    if (nodes > 0 && unseen == nodes) {
      rows.push_back({escaped(symbol), "–", "", "–", "not seen"});
      continue;
    }
    const std::string hidden =
        unseen > 0 ? ", " + fixed_text(unseen, 0) + " of " + fixed_text(nodes, 0) + " nodes not seen" : "";
    rows.push_back({escaped(symbol),
                    quantity(number_at(e, {"largest"}).value_or(NAN), number_at(e, {"std"}), text_at(e, "unit")),
                    e.contains("at") ? position(e["at"]) : "", probability(number_at(e, {"p_value"}).value_or(1)),
                    (e.value("told_from_zero", false) ? "yes" : "no") + hidden});
  }
  return html_table("The twelve errors of the rotary axes where each is largest",
                    {"error", "largest, with standard uncertainty", "at", "p of being zero", "told from zero"}, rows);
}

std::string location_table(const json& fit) {
  if (!fit.contains("location_errors") || !fit["location_errors"].contains("values")) return "";
  const json& location = fit["location_errors"];
  std::vector<std::vector<std::string>> rows;
  for (const auto& [symbol, e] : location["values"].items())
    rows.push_back(
        {escaped(symbol), quantity(number_at(e, {"value"}).value_or(NAN), number_at(e, {"std"}), text_at(e, "unit"))});
  return html_table("Location errors in these maps (ISO 230-1)", {"error", "value, with standard uncertainty"}, rows) +
         element("p", location.value("location_errors_only", false)
                          ? "Nothing beyond these location errors is told from noise."
                          : "These alone do not explain the maps: the errors move with the angles.");
}

std::string fact(const std::string& term, const std::string& said) { return element("dt", term) + element("dd", said); }

std::string quality(const json& fit) {
  const auto number = [&](const char* key) { return quantity(number_at(fit, {key}).value_or(NAN), std::nullopt, ""); };
  const bool declared = !fit.contains("sigma_declared_um") || !fit["sigma_declared_um"].is_null();
  std::string facts;
  facts += fact("Readings, unknowns, degrees of freedom",
                number("readings") + ", " + number("unknowns") + ", " + number("degrees_of_freedom"));
  facts +=
      fact("Standard deviation of a reading: found, declared",
           number("sigma_found_um") + "\u00a0µm, " + (declared ? number("sigma_declared_um") + "\u00a0µm" : "none"));
  const double p = number_at(fit, {"chi2_p"}).value_or(NAN);
  facts += fact("Reduced chi-square", number("reduced_chi2") + " (p " + probability(p) + ")" +
                                          (!declared   ? ": by construction"
                                           : p < 1e-3  ? ": more scatter than the probe has"
                                           : p >= 1e-3 ? ": as declared"
                                                       : ""));
  if (const auto scale = number_at(fit, {"uncertainty_scale"}); scale && *scale > 1)
    facts += fact("Uncertainties enlarged by", quantity(*scale, std::nullopt, ""));
  const std::size_t unchecked = fit.contains("unchecked_lines") ? fit["unchecked_lines"].size() : 0;
  facts += fact("Redundancy", "least of a reading " + number("worst_redundancy") + "; " + std::to_string(unchecked) +
                                  " readings that no other checks");
  std::string outliers;
  if (fit.contains("outliers"))
    for (const json& o : fit["outliers"])
      outliers += (outliers.empty() ? "" : "; ") + std::string("line ") +
                  quantity(o.value("line", 0), std::nullopt, "") + ": " +
                  quantity(o.value("residual_um", o.value("residual_urad", 0.0)), std::nullopt,
                           o.contains("residual_um") ? "um" : "urad");
  facts += fact("Outliers, left out", outliers.empty() ? "none" : outliers);
  std::string unseen;
  if (fit.contains("unseen_freedoms"))
    for (const json& f : fit["unseen_freedoms"])
      unseen += (unseen.empty() ? "" : "; ") + position(f) + ": " +
                word_list(f.contains("components") ? f["components"] : json::array());
  facts += fact("Freedoms that no reading saw", unseen.empty() ? "none" : unseen);
  facts += fact("Not determined", word_list(fit.contains("undetermined") ? fit["undetermined"] : json::array()));
  return element("dl", facts, "class=\"facts\"");
}

}  // namespace

Section identification_section(const Evidence& evidence) {
  const ResultFile* result = identified(evidence);
  if (result == nullptr) return {};
  const json& model = *result->content;
  Section section{"identification", "Identification", ""};
  const bool fitted = model.contains("fit") && model["fit"].contains("errors") && model["fit"]["errors"].is_object();
  if (fitted) {
    const json& fit = model["fit"];
    section.html += quality(fit) + error_table(fit);
    std::string names;
    for (const std::string unit : {"um", "urad"}) {
      std::string largest;
      for (const auto& [symbol, e] : fit["errors"].items())
        if (text_at(e, "unit") == unit && number_at(e, {"largest"}) &&
            (largest.empty() ||
             std::abs(e["largest"].get<double>()) > std::abs(fit["errors"][largest]["largest"].get<double>())))
          largest = symbol;
      if (largest.empty()) continue;
      const json& e = fit["errors"][largest];
      names += (names.empty() ? "" : "; ") + escaped(largest) + " = <strong>" +
               quantity(e["largest"].get<double>(), number_at(e, {"std"}), unit) + "</strong> at " +
               position(e.contains("at") ? e["at"] : json());
    }
    section.sentence = names.empty() ? "These readings determine none of the errors of the rotary axes."
                                     : "The largest errors of the rotary axes: " + names + " (standard uncertainty).";
  }
  if (const json* map = map_of(model)) section.html += map_charts(*map);
  if (fitted) section.html += location_table(model["fit"]);
  return section;
}

Section interpolation_section(const Evidence& evidence) {
  const ResultFile* result = identified(evidence);
  if (result == nullptr || !result->content->contains("fit")) return {};
  const json& fit = (*result->content)["fit"];
  if (!fit.contains("interpolation") || !fit["interpolation"].contains("left_out_angles")) return {};
  const json& evidence_of = fit["interpolation"]["left_out_angles"];
  if (!evidence_of.is_object() || evidence_of.empty()) return {};
  const std::string chosen = text_at(fit["interpolation"], "chosen");
  std::vector<std::vector<std::string>> rows;
  std::map<std::string, std::map<double, std::map<std::string, double>>> missed;  // axis, angle, method
  for (const auto& [method, e] : evidence_of.items()) {
    rows.push_back({escaped(method) + (method == chosen ? " (chosen)" : ""),
                    quantity(number_at(e, {"displacement_rms_um"}).value_or(NAN), std::nullopt, "um"),
                    quantity(number_at(e, {"D_rms_um"}).value_or(NAN), std::nullopt, "um"),
                    quantity(number_at(e, {"theta_rms_urad"}).value_or(NAN), std::nullopt, "urad"),
                    quantity(number_at(e, {"poses"}).value_or(NAN), std::nullopt, "")});
    if (e.contains("angles"))
      for (const json& angle : e["angles"])
        if (number_at(angle, {"angle_deg"}) && number_at(angle, {"displacement_rms_um"}))
          missed[text_at(angle, "axis")][angle["angle_deg"].get<double>()][method] =
              angle["displacement_rms_um"].get<double>();
  }
  Section section{"interpolation", "Between the measured angles", ""};
  section.html =
      element("p",
              "Each angle was left out in turn, predicted from the others, and compared with what had been "
              "measured there; as a displacement at a lever of 100 mm.") +
      html_table("Left-out angles are missed by (rms)", {"method", "displacement", "lengths", "angles", "poses"}, rows);
  std::string figures;
  for (const auto& [axis, angles] : missed) {
    if (angles.size() < 2) continue;
    Chart chart{.title = "Left-out angles of " + axis,
                .x_label = axis + " left out, deg",
                .y_label = "missed by, µm rms",
                .x_name = axis,
                .y_unit = "µm",
                .x = {},
                .series = {}};
    for (const auto& [method, ignored] : evidence_of.items()) chart.series.push_back({method, {}});
    for (const auto& [angle, methods] : angles) {
      chart.x.push_back(angle);
      for (ChartSeries& series : chart.series) {
        const auto found = methods.find(series.name);
        series.values.push_back(found == methods.end() ? std::nan("") : found->second);
      }
    }
    figures += chart_figure(chart);
  }
  section.html += element("div", figures, "class=\"charts\"");
  if (const auto miss =
          evidence_of.contains(chosen) ? number_at(evidence_of[chosen], {"displacement_rms_um"}) : std::nullopt)
    section.sentence = "At angles that were not measured, " + escaped(chosen) + " misses by <strong>" +
                       quantity(*miss, std::nullopt, "um") + "</strong> rms at 100 mm.";
  return section;
}

}  // namespace trunnion
