#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

#include "report/chart.h"
#include "report/html.h"
#include "report/sections.h"

namespace trunnion {
namespace {

using nlohmann::json;

constexpr std::size_t kKinds = 6;  ///< values of a number that are told as kinds, side by side
constexpr double kSpread = 0.32;   ///< to either side, over which the readings of one kind are spread in their order

/// Columns of residuals.csv that are no covariates.
const std::set<std::string> kNoCovariate = {"file",      "line",    "residual_before_um", "residual_after_um",
                                            "kept_back", "left_out"};

/// "temperature_C" → "temperature, °C".
std::string label_of(const std::string& column) {
  static const std::map<std::string, std::string> kUnits = {{"_deg", ", deg"}, {"_mm", ", mm"}, {"_s", ", s"},
                                                            {"_C", ", °C"},    {"_kg", ", kg"}, {"_um", ", µm"}};
  for (const auto& [ending, unit] : kUnits)
    if (column.ends_with(ending)) return column.substr(0, column.size() - ending.size()) + unit;
  static const std::map<std::string, std::string> kNames = {{"order", "order of the readings, count"},
                                                            {"order_in_pose", "order within the pose, count"},
                                                            {"repeat", "pass, count"},
                                                            {"point", "spot, as recorded"},
                                                            {"A_dir", "sense of A's last motion, ±1"},
                                                            {"B_dir", "sense of B's last motion, ±1"},
                                                            {"C_dir", "sense of C's last motion, ±1"},
                                                            {"nx", "approach along X, 1"},
                                                            {"ny", "approach along Y, 1"},
                                                            {"nz", "approach along Z, 1"}};
  const auto found = kNames.find(column);
  return found == kNames.end() ? column + ", as recorded" : found->second;
}

/// The residuals over one covariate, in the order in which `x` ascends; no series where it does not vary.
Chart residual_chart(const NumberColumns& columns, const std::string& column, const std::vector<double>& x,
                     std::vector<std::string> categories) {
  const auto left_out = columns.find("left_out");
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (std::isfinite(x[i]) && (left_out == columns.end() || left_out->second[i] == 0)) order.push_back(i);
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return x[i]; });
  const std::string label = label_of(column), name = label.substr(0, label.find(','));
  Chart chart{.title = "Residual over " + name,
              .x_label = label,
              .y_label = "residual, µm",
              .x_name = name,
              .y_unit = "µm",
              .x = {},
              .series = {},
              .marks = ChartMarks::points,
              .categories = std::move(categories)};
  if (order.empty() || x[order.front()] == x[order.back()] || chart.categories.size() == 1) return chart;
  for (const auto& [key, title] :
       {std::pair("residual_before_um", "before"), std::pair("residual_after_um", "after")}) {
    const auto values = columns.find(key);
    if (values == columns.end()) continue;
    ChartSeries& series = chart.series.emplace_back(ChartSeries{title, {}});
    for (const std::size_t i : order) series.values.push_back(values->second[i]);
  }
  for (const std::size_t i : order) chart.x.push_back(x[i]);
  return chart;
}

/// Kinds side by side in the order of `names`, the readings of each spread in the order in which they were taken.
std::vector<double> spread(const std::vector<std::string>& kinds, const std::vector<std::string>& names) {
  std::vector<std::size_t> of(kinds.size()), count(names.size(), 0), seen(names.size(), 0);
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    of[i] = static_cast<std::size_t>(std::ranges::find(names, kinds[i]) - names.begin());
    if (of[i] < names.size()) ++count[of[i]];
  }
  std::vector<double> x;
  for (const std::size_t k : of) {
    if (k == names.size()) {
      x.push_back(std::nan(""));
      continue;
    }
    const double share = count[k] > 1 ? static_cast<double>(seen[k]) / static_cast<double>(count[k] - 1) : 0.5;
    x.push_back(static_cast<double>(k) + kSpread * (2 * share - 1));
    ++seen[k];
  }
  return x;
}

/// A covariate that is told by words, or that has few values.
Chart kinds_chart(const NumberColumns& columns, const TextColumns& labels, const std::string& column) {
  std::vector<std::string> kinds, names;
  if (const auto text = labels.find(column); text != labels.end()) {
    kinds = text->second;
    names = kinds;
    std::ranges::sort(names);
  } else {
    std::vector<double> values = columns.at(column);
    for (const double value : values) kinds.push_back(std::isfinite(value) ? quantity(value, std::nullopt, "") : "");
    std::ranges::sort(values);
    for (const double value : values)
      if (std::isfinite(value)) names.push_back(quantity(value, std::nullopt, ""));
  }
  names.erase(std::unique(names.begin(), names.end()), names.end());
  std::erase(names, "");
  const std::vector<double> x = spread(kinds, names);
  return residual_chart(columns, column, x, std::move(names));
}

std::string residual_charts(const NumberColumns& columns, const TextColumns& labels) {
  std::string figures;
  for (const auto& [column, values] : columns) {
    if (kNoCovariate.contains(column)) continue;
    std::set<double> different;
    for (const double value : values)
      if (std::isfinite(value) && different.size() <= kKinds) different.insert(value);
    const Chart chart = labels.contains(column) || different.size() <= kKinds
                            ? kinds_chart(columns, labels, column)
                            : residual_chart(columns, column, values, {});
    if (chart.series.size() == 2) figures += chart_figure(chart);
  }
  if (figures.empty()) return "";
  return element("h3", "The residual against every covariate, before and after") +
         element("div", figures, "class=\"charts\"");
}

std::string um(const json& j, const std::vector<std::string>& keys) {
  const auto value = number_at(j, keys);
  return value ? quantity(*value, std::nullopt, "um") : "–";
}

std::string parameters_text(const json& effect) {
  if (!effect.contains("parameters") || !effect["parameters"].is_object()) return "";
  if (text_at(effect, "kind") == "smooth") return std::to_string(effect["parameters"].size()) + " coefficients";
  std::string text;
  for (const auto& [name, p] : effect["parameters"].items())
    text += (text.empty() ? "" : "<br>") + escaped(name) + " = " +
            quantity(number_at(p, {"value"}).value_or(NAN), number_at(p, {"std"}), text_at(p, "unit"));
  return text;
}

/// What was considered in its place, and by how much the readings prefer what was taken.
std::string alternatives_text(const json& effect) {
  if (!effect.contains("alternatives") || !effect["alternatives"].is_array() || effect["alternatives"].empty())
    return "none";
  std::string text;
  for (const json& a : effect["alternatives"]) {
    text += (text.empty() ? "" : "<br>") + escaped(text_at(a, "id"));
    if (const auto behind = number_at(a, {"log_likelihood_behind"}))
      text += ", behind by " + quantity(*behind, std::nullopt, "");
  }
  return text;
}

/// Whether an effect is compensated, and what must be known for it.
std::string compensated_text(const json& effect) {
  if (!effect.value("compensated", text_at(effect, "origin") == "machine")) return "no";
  return effect.contains("needs") && !effect["needs"].empty() ? "where known: " + word_list(effect["needs"]) : "yes";
}

std::string effects_html(const json& closure) {
  if (!closure.contains("effects") || closure["effects"].empty())
    return element("p", "The readings show nothing that the error maps lack.");
  std::vector<std::vector<std::string>> rows, doubts;
  for (const json& e : closure["effects"]) {
    const std::string id = escaped(text_at(e, "id"));
    rows.push_back({id, text_at(e, "origin") == "machine" ? "the machine" : "the measurement", compensated_text(e),
                    parameters_text(e), um(e, {"largest_um"}), probability(number_at(e, {"p_value"}).value_or(NAN)),
                    quantity(number_at(e, {"visible_fraction"}).value_or(NAN), std::nullopt, ""),
                    um(e, {"rms_before_um"}) + " → " + um(e, {"rms_after_um"}),
                    um(e, {"holdout_before_um"}) + " → " + um(e, {"holdout_after_um"})});
    const std::string separate = text_at(e, "separate_by");
    doubts.push_back({id, word_list(e.contains("not_separable_from") ? e["not_separable_from"] : json::array()),
                      separate.empty() ? "–" : escaped(separate), alternatives_text(e)});
  }
  return html_table(
             "What was found, each with its evidence",
             {"effect", "belongs to", "compensated", "parameters, with standard uncertainty", "largest in a reading",
              "p, family-wise", "visible fraction", "residual, rms", "poses kept back, rms"},
             rows) +
         html_table("What these data cannot tell apart",
                    {"effect", "cannot be told from", "to separate them", "considered instead (log likelihood)"},
                    doubts);
}

std::string open_questions(const json& closure) {
  std::string text;
  if (closure.contains("untestable") && !closure["untestable"].empty()) {
    std::vector<std::vector<std::string>> rows;
    for (const json& u : closure["untestable"])
      rows.push_back({escaped(text_at(u, "id")), escaped(text_at(u, "separate_by"))});
    text += html_table("What could not be tested, and what to measure next", {"effect", "measure"}, rows);
  }
  if (closure.contains("refused") && !closure["refused"].empty()) {
    std::string lines;
    for (const json& line : closure["refused"])
      if (line.is_string()) lines += element("li", escaped(line.get<std::string>()));
    text += element("details", element("summary", "Tried and refused") + element("ul", lines));
  }
  if (closure.contains("outliers") && !closure["outliers"].empty())
    text += element("p", "Left out as outliers: " + word_list(closure["outliers"]) + ".");
  return text;
}

/// What the search changed at the corners of the working volume.
std::string corners_table(const json& closure) {
  if (!closure.contains("map_change") || !closure["map_change"].contains("corners")) return "";
  std::vector<std::vector<std::string>> rows;
  for (const json& corner : closure["map_change"]["corners"]) {
    std::string place;
    for (const char* key : {"x_mm", "y_mm", "z_mm"})
      place += (place.empty() ? "" : ", ") + quantity(number_at(corner, {key}).value_or(NAN), std::nullopt, "");
    rows.push_back({place, um(corner, {"map_rms_um"}), um(corner, {"map_max_um"}), um(corner, {"model_rms_um"}),
                    um(corner, {"model_max_um"})});
  }
  return html_table("What this changes at the corners of the working volume",
                    {"X, Y, Z in mm", "maps, rms", "maps, largest", "all that is compensated, rms",
                     "all that is compensated, largest"},
                    rows);
}

std::string stages_table(const json& closure) {
  std::vector<std::vector<std::string>> rows;
  const auto row = [&](const std::string& title, const char* part, const char* key, const char* unit) {
    std::vector<std::string> cells = {title};
    for (const char* stage : {"before", "after"}) {
      std::vector<std::string> keys = {stage, key};
      if (*part != '\0') keys.insert(keys.begin(), part);
      const auto value = number_at(closure, keys);
      cells.push_back(value ? quantity(*value, std::nullopt, unit) : "–");
    }
    rows.push_back(std::move(cells));
  };
  row("residual, rms", "", "rms_um", "um");
  row("reduced chi-square", "", "reduced_chi2", "");
  row("poses kept back, rms", "", "holdout_rms_um", "um");
  if (closure.contains("piece")) {
    row("piece, measured less predicted, rms", "piece", "rms_um", "um");
    row("piece, roundness of that", "piece", "roundness_um", "um");
  }
  return html_table("The residual before and after", {"", "before", "after"}, rows) +
         element("p", "Declared standard deviation of a reading: " + um(closure, {"noise_um"}) + ".");
}

}  // namespace

Section closure_section(const Evidence& evidence) {
  Section section{"closure", "Closing the loop", ""};
  for (const ResultFile& r : evidence.results) {
    if (r.kind != ResultKind::closure) continue;
    const json& closure = *r.content;
    const std::string verdict = escaped(text_at(closure, "verdict", "no verdict"));
    section.html += element("p", "<strong>Verdict: " + verdict + ".</strong> " + escaped(r.path), "class=\"verdict\"") +
                    stages_table(closure) + effects_html(closure) + corners_table(closure) + open_questions(closure) +
                    residual_charts(r.columns, r.labels);
    std::string names;
    if (closure.contains("effects"))
      for (const json& e : closure["effects"]) names += (names.empty() ? "" : ", ") + escaped(text_at(e, "id"));
    section.sentence += (section.sentence.empty() ? "" : " ") + std::string("What a map cannot hold: <strong>") +
                        verdict + "</strong>" + (names.empty() ? "" : " (" + names + ")") + ", residual " +
                        um(closure, {"before", "rms_um"}) + " → " + um(closure, {"after", "rms_um"}) + " rms.";
  }
  return section.html.empty() ? Section{} : section;
}

}  // namespace trunnion
