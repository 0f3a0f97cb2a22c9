#include "report/evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

#include "error.h"
#include "report/page.h"
#include "units/number_text.h"

namespace trunnion {
namespace {

using nlohmann::json;

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kMostPoints = 4000;  // of a cloud
constexpr const char* kCovariates[][2] = {{"time_s", "time, s"},
                                          {"order", "order of the touches"},
                                          {"A_deg", "A, deg"},
                                          {"B_deg", "B, deg"},
                                          {"C_deg", "C, deg"},
                                          {"x_mm", "X, mm"},
                                          {"y_mm", "Y, mm"},
                                          {"z_mm", "Z, mm"},
                                          {"nz", "n_z of the approach"},
                                          {"temperature_C", "temperature, C"}};

/// A file with its text read.
struct Result {
  std::string path;
  json content;
  const std::map<std::string, NumberTable>& tables;
  const std::map<std::string, std::string>& pictures;
};

double number(const json& j, const char* key) {
  return j.is_object() && j.contains(key) && j[key].is_number() ? j[key].get<double>() : kMissing;
}
std::string text(const json& j, const char* key) {
  return j.is_object() && j.contains(key) && j[key].is_string() ? j[key].get<std::string>() : "";
}
const json& part(const json& j, const char* key) {
  static const json nothing;
  return j.is_object() && j.contains(key) ? j[key] : nothing;
}
std::string shown(double value, const char* format = "%.3f") {
  return std::isfinite(value) ? formatted(format, value) : "–";
}
std::string shown_with(double value, double std) {
  if (!std::isfinite(value)) return "–";
  return std::isfinite(std) && std > 0 ? with_uncertainty(value, std) : formatted("%.4g", value);
}
std::string listed(const json& list) {
  std::string out;
  for (const json& entry : list)
    if (entry.is_string()) out += (out.empty() ? "" : ", ") + entry.get<std::string>();
  return out;
}
std::vector<double> numbers(const json& list) {
  std::vector<double> out;
  for (const json& v : list) out.push_back(v.is_number() ? v.get<double>() : kMissing);
  return out;
}

void provenance(Page& page, const Result& file) {
  std::string line = file.path + ", written by " + text(file.content, "program");
  const json& inputs = part(file.content, "inputs_sha256").is_null() ? part(part(file.content, "fit"), "inputs_sha256")
                                                                     : part(file.content, "inputs_sha256");
  std::vector<std::vector<std::string>> rows = {{"made from", "SHA-256"}};
  for (const auto& [name, hash] : inputs.items())
    if (hash.is_string()) rows.push_back({name, hash.get<std::string>()});
  if (text(file.content, "program").empty())
    line = file.path + ", written by " + text(part(file.content, "fit"), "program");
  page.paragraph(line, "note");
  page.table(rows, "Inputs of " + file.path);
}

// -- identification ---------------------------------------------------------------------------------------------------

std::vector<Chart> map_charts(const json& map) {
  std::vector<Chart> charts;
  const json &grid = part(map, "grid_deg"), &values = part(map, "values"), &stds = part(map, "std");
  const std::string tilt = grid.contains("B") ? "B" : "A";
  const std::vector<double> a = numbers(part(grid, tilt.c_str())), c = numbers(part(grid, "C"));
  for (const auto& [symbol, entry] : values.items()) {
    const json &data = part(entry, "data"), &std = part(part(stds, symbol.c_str()), "data");
    Chart chart{.title = symbol, .y_label = symbol + ", " + text(entry, "unit")};
    const auto band = [](const json& row) {
      std::vector<double> half = numbers(row);
      for (double& h : half) h *= 2;
      return half;
    };
    if (!data.empty() && data.front().is_array()) {
      chart.x_label = "C, deg";
      chart.x = c;
      for (std::size_t i = 0; i < data.size() && i < a.size(); ++i)
        chart.series.push_back({tilt + " = " + formatted("%.4g", a[i]) + " deg", numbers(data[i]),
                                std.is_array() && i < std.size() ? band(std[i]) : std::vector<double>{}});
    } else {
      chart.x_label = tilt + ", deg";
      chart.x = a;
      chart.series.push_back({"", numbers(data), std.is_array() ? band(std) : std::vector<double>{}});
    }
    const bool fits = std::ranges::all_of(chart.series, [&](const ChartSeries& s) {
      return s.y.size() == chart.x.size() && (s.half_width.empty() || s.half_width.size() == s.y.size());
    });
    if (!fits || !std::ranges::is_sorted(chart.x)) continue;
    charts.push_back(std::move(chart));
  }
  std::ranges::stable_sort(charts, {}, [](const Chart& chart) { return chart.title.back() == 'C'; });
  return charts;
}

void interpolation_section(Page& page, const json& fit) {
  const json& interpolation = part(fit, "interpolation");
  if (!interpolation.is_object()) return;
  page.heading("Between the measured angles");
  page.paragraph("Each C column and inner tilt was left out in turn and predicted from the others; chosen: " +
                 text(interpolation, "chosen") + ".");
  std::vector<std::vector<std::string>> rows = {{"interpolation", "missed by, um rms", "rotation missed by, urad rms"}};
  for (const auto& [name, found] : part(interpolation, "left_out_angles").items())
    rows.push_back({name, shown(number(found, "D_rms_um")), shown(number(found, "rotation_rms_urad"))});
  page.table(rows, "Leave-one-angle-out, displacement of R's origin and rotation");
}

void model_section(Page& page, const Result& file) {
  const json& fit = part(file.content, "fit");
  page.section("identification", "Identification",
               "What is wrong with the rotary axes, with bands of two standard "
               "uncertainties.");
  if (fit.contains("readings"))
    page.paragraph(formatted("%.0f readings, ", number(fit, "readings")) +
                   formatted("%.0f unknowns, ", number(fit, "unknowns")) + "reduced chi-square " +
                   shown(number(fit, "reduced_chi2")) + ", noise declared " + shown(number(fit, "sigma_declared_um")) +
                   " um, found " + shown(number(fit, "sigma_found_um")) +
                   " um; outliers: " + std::to_string(part(fit, "outliers").size()) + "; freedoms no reading shows: " +
                   (part(fit, "unseen_freedoms").empty() ? "none" : listed(part(fit, "unseen_freedoms"))) + ".");
  std::vector<std::vector<std::string>> rows = {{"error", "largest", "unit", "at", "told from zero"}};
  const json errors = part(fit, "errors");
  for (const auto& [symbol, e] : errors.items()) {
    std::string at;
    for (const auto& [axis, angle] : part(e, "at").items())
      at += (at.empty() ? "" : ", ") + axis.substr(0, 1) + " " + formatted("%.4g", angle.get<double>());
    rows.push_back({symbol, shown_with(number(e, "largest"), number(e, "std")), symbol[1] >= 'X' ? "um" : "urad", at,
                    number(e, "p_value") < 0.01 ? "yes, p " + p_value_text(number(e, "p_value")) : "no"});
  }
  page.table(rows, "The largest value of each error");
  rows = {{"location error", "value", "unit"}};
  const json located = part(part(fit, "location_errors"), "values");
  for (const auto& [symbol, e] : located.items())
    rows.push_back({symbol, shown_with(number(e, "value"), number(e, "std")), text(e, "unit")});
  page.table(rows, "Location errors within the maps (ISO 230-7)");
  for (const json& effect : part(file.content, "effects"))
    if (text(effect, "id") == "rotary_error_map") page.charts(map_charts(effect));
  interpolation_section(page, fit);
  provenance(page, file);
}

// -- closure ----------------------------------------------------------------------------------------------------------

std::vector<Chart> residual_charts(const NumberTable& residuals) {
  std::vector<Chart> charts;
  const auto before = residuals.find("residual_before_um"), after = residuals.find("residual_after_um");
  if (before == residuals.end() || after == residuals.end()) return charts;
  for (const auto& [column, label] : kCovariates) {
    const auto covariate = residuals.find(column);
    if (covariate == residuals.end() || covariate->second.empty()) continue;
    const std::vector<double>& v = covariate->second;
    const auto [low, high] = std::ranges::minmax(v);
    if (!(high > low)) continue;
    std::vector<std::size_t> order(v.size());
    std::iota(order.begin(), order.end(), 0U);
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return v[i]; });
    Chart chart{.title = std::string("Residual against ") + label,
                .x_label = label,
                .y_label = "residual, um",
                .points = true,
                .series = {{"before", {}, {}}, {"after", {}, {}}}};
    const std::size_t stride = v.size() / kMostPoints + 1;
    for (std::size_t k = 0; k < order.size(); k += stride) {
      chart.x.push_back(v[order[k]]);
      chart.series[0].y.push_back(before->second[order[k]]);
      chart.series[1].y.push_back(after->second[order[k]]);
    }
    charts.push_back(std::move(chart));
  }
  return charts;
}

void closure_section(Page& page, const Result& file) {
  const json& c = file.content;
  page.section("closure", "Closing the loop",
               "Whether the readings show something that the maps cannot hold, and what.");
  page.paragraph("Verdict: " + text(c, "verdict") + ".", "verdict");
  const json &before = part(c, "before"), &after = part(c, "after");
  page.table(
      {{"", "before", "after", "unit"},
       {"residual rms", shown(number(before, "rms_um")), shown(number(after, "rms_um")), "um"},
       {"reduced chi-square", shown(number(before, "reduced_chi2")), shown(number(after, "reduced_chi2")), ""},
       {"poses kept back", shown(number(before, "holdout_rms_um")), shown(number(after, "holdout_rms_um")), "um"}},
      "Error before and after; declared noise " + shown(number(c, "noise_um")) + " um");
  for (const json& e : part(c, "effects")) {
    page.heading(text(e, "id"));
    page.paragraph("Belongs to the " + text(e, "origin") + "; depends on " + listed(part(e, "depends_on")) +
                   ". Family-wise p " + p_value_text(number(e, "p_value")) + ", visible fraction " +
                   shown(number(e, "visible_fraction"), "%.2f") + ", up to " + shown(number(e, "largest_um"), "%.2f") +
                   " um in a reading; poses kept back " + shown(number(e, "holdout_before_um")) + " to " +
                   shown(number(e, "holdout_after_um")) + " um. " +
                   (part(e, "compensated").is_boolean() && part(e, "compensated").get<bool>() ? "Compensated"
                                                                                              : "Not compensated") +
                   (part(e, "needs").empty() ? "." : ", where " + listed(part(e, "needs")) + " is told."));
    std::vector<std::vector<std::string>> rows = {{"parameter", "value", "unit"}};
    const json parameters = part(e, "parameters");
    if (parameters.size() <= 12)
      for (const auto& [name, p] : parameters.items())
        rows.push_back({name, shown_with(number(p, "value"), number(p, "std")), text(p, "unit")});
    page.table(rows, "Parameters of " + text(e, "id"));
    if (!part(e, "not_separable_from").empty())
      page.paragraph("These data cannot tell it from " + listed(part(e, "not_separable_from")) +
                     ". To separate: " + text(e, "separate_by") + ".");
    rows = {{"also offered", "shares of the fitted effect", "behind in log likelihood"}};
    for (const json& a : part(e, "alternatives"))
      rows.push_back(
          {text(a, "id"), shown(number(a, "correlation"), "%.2f"), shown(number(a, "log_likelihood_behind"), "%.1f")});
    page.table(rows, "Alternatives to " + text(e, "id"));
  }
  const auto residuals = file.tables.find("residuals.csv");
  if (residuals != file.tables.end()) page.charts(residual_charts(residuals->second));
  std::vector<std::vector<std::string>> rows = {
      {"X Y Z, mm", "maps rms, um", "largest", "all that is compensated rms, um", "largest"}};
  for (const json& corner : part(part(c, "map_change"), "corners"))
    rows.push_back({shown(number(corner, "x_mm"), "%.0f ") + shown(number(corner, "y_mm"), "%.0f ") +
                        shown(number(corner, "z_mm"), "%.0f"),
                    shown(number(corner, "map_rms_um"), "%.2f"), shown(number(corner, "map_max_um"), "%.2f"),
                    shown(number(corner, "model_rms_um"), "%.2f"), shown(number(corner, "model_max_um"), "%.2f")});
  page.table(rows, "Change at the corners of the working volume");
  rows = {{"cannot be tested with these data", "what would test it"}};
  for (const json& u : part(c, "untestable")) rows.push_back({text(u, "id"), text(u, "separate_by")});
  page.table(rows, "What these data say nothing about");
  for (const json& line : part(c, "refused"))
    if (line.is_string()) page.paragraph("Tried and refused: " + line.get<std::string>(), "note");
  provenance(page, file);
}

// -- compensation, correction -----------------------------------------------------------------------------------------

void tables_section(Page& page, const std::vector<const Result*>& files) {
  page.section("compensation", "Compensation tables",
               "Each set read back and played as its control would, over poses of the working volume.");
  std::vector<std::vector<std::string>> rows = {{"control", "before, um rms", "ideal", "as played", "before, urad rms",
                                                 "as played", "lost to format", "to spacing", "to rounding",
                                                 "load-ready"}};
  for (const Result* file : files) {
    const json &v = file->content, &p = part(v, "position_rms_um"), &o = part(v, "orientation_rms_urad"),
               &lost = part(v, "lost_to");
    const bool ready = part(v, "load_ready").is_boolean() && part(v, "load_ready").get<bool>();
    rows.push_back({text(v, "controller"), shown(number(p, "before")), shown(number(p, "ideal")),
                    shown(number(p, "tables")), shown(number(o, "before"), "%.2f"), shown(number(o, "tables"), "%.2f"),
                    shown(number(lost, "format")), shown(number(lost, "spacing")), shown(number(lost, "quantisation")),
                    ready ? "yes" : "no: " + listed(part(v, "unconfirmed"))});
  }
  page.table(rows, "What each control achieves; losses in um rms");
  for (const Result* file : files) provenance(page, *file);
}

void correction_section(Page& page, const Result& file) {
  const json &c = file.content, &before = part(part(c, "playback"), "before"),
             &after = part(part(c, "playback"), "after");
  page.section("correction", "Corrected program",
               "The program as written, and the corrected text read back and played on the model.");
  page.table(
      {{"", "as written", "corrected", "unit"},
       {"position, rms", shown(number(before, "position_rms_um")), shown(number(after, "position_rms_um")), "um"},
       {"position, largest", shown(number(before, "position_max_um")), shown(number(after, "position_max_um")), "um"},
       {"tool axis, rms", shown(number(before, "orientation_rms_urad"), "%.2f"),
        shown(number(after, "orientation_rms_urad"), "%.2f"), "urad"},
       {"tool axis, largest", shown(number(before, "orientation_max_urad"), "%.2f"),
        shown(number(after, "orientation_max_urad"), "%.2f"), "urad"}},
      "What is left along the program; dialect " + text(c, "dialect"));
  const json& along = part(part(c, "playback"), "along");
  if (along.is_object()) {
    std::vector<Chart> charts;
    const std::vector<double> line = numbers(part(along, "line"));
    for (const auto& [what, unit] : {std::pair("position", "um"), std::pair("orientation", "urad")}) {
      Chart chart{.title = std::string("Deviation of ") + what + " along the program",
                  .x_label = "line of the program",
                  .y_label = std::string(what) + ", " + unit,
                  .x = line};
      for (const char* stage : {"before", "after"}) {
        const json& values = part(along, (std::string(what) + "_" + stage + "_" + unit).c_str());
        if (values.is_array() && values.size() == line.size()) chart.series.push_back({stage, numbers(values), {}});
      }
      if (!chart.series.empty() && std::ranges::is_sorted(chart.x)) charts.push_back(std::move(chart));
    }
    page.charts(charts);
  }
  provenance(page, file);
}

// -- test piece -------------------------------------------------------------------------------------------------------

constexpr const char* kVariants[] = {"uncompensated", "tables", "corrected", "ideal"};

void piece_view(Page& page, const Result& file) {
  const auto found = file.tables.find("flank.csv");
  if (found == file.tables.end()) return;
  const NumberTable& flank = found->second;
  const auto phi = flank.find("phi_deg"), h = flank.find("h_mm");
  if (phi == flank.end() || h == flank.end()) return;
  const std::set<double> heights(h->second.begin(), h->second.end()), around(phi->second.begin(), phi->second.end());
  if (heights.size() * around.size() != phi->second.size() || heights.size() < 2 || around.size() < 3) return;
  std::vector<std::size_t> order(phi->second.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return std::pair(h->second[i], phi->second[i]); });
  json part_json = {{"h_mm", heights},
                    {"phi_deg", around},
                    {"variants", json::array()},
                    {"base_diameter_mm", number(part(file.content, "piece"), "base_diameter_mm")},
                    {"half_angle_deg", number(part(file.content, "piece"), "half_angle_deg")}};
  double largest = 0;
  Chart still{.title = "The middle of the flank",
              .x_label = "phi, deg",
              .y_label = "deviation, um",
              .x = {around.begin(), around.end()}};
  for (const char* variant : kVariants) {
    const auto column = flank.find(std::string(variant) + "_um");
    if (column == flank.end()) continue;
    json um = json::array();
    ChartSeries middle{variant, {}, {}};
    const std::size_t from = (heights.size() / 2) * around.size();
    for (std::size_t k = 0; k < order.size(); ++k) {
      const double value = column->second[order[k]];
      if (std::string(variant) == "uncompensated") largest = std::max(largest, std::abs(value));
      um.push_back(std::round(value * 1e4) / 1e4);
      if (k >= from && k < from + around.size()) middle.y.push_back(value);
    }
    part_json["variants"].push_back({{"name", variant}, {"um", std::move(um)}});
    still.series.push_back(std::move(middle));
  }
  part_json["largest_um"] = largest > 0 ? largest : 1;
  page.heading("The part");
  page.part(part_json.dump(), still_svg(still));
  page.charts({still});
}

void piece_section(Page& page, const Result& file) {
  const json& p = file.content;
  page.section("piece", "Test piece",
               "What a coordinate measuring machine will find on the cone frustum of ISO 10791-7.");
  std::vector<std::vector<std::string>> rows = {
      {"", "rms, um", "largest, um", "form, um", "roundness (LSC), um, by height", "axis tilt, urad"}};
  for (const char* variant : kVariants) {
    const json& v = part(p, variant);
    if (!v.is_object()) continue;
    std::string round;
    for (const json& height : part(v, "heights"))
      round += (round.empty() ? "" : "; ") + shown_with(number(height, "lsc_um"), number(height, "lsc_um_sd"));
    rows.push_back({variant, shown_with(number(v, "rms_um"), number(v, "rms_um_sd")), shown(number(v, "max_um")),
                    shown_with(number(v, "form_um"), number(v, "form_um_sd")), round,
                    shown_with(number(v, "axis_tilt_urad"), number(v, "axis_tilt_urad_sd"))});
  }
  page.table(rows, "With the standard uncertainty that the map gives each value");
  for (const json& note : part(p, "notes"))
    if (note.is_string()) page.paragraph(note.get<std::string>(), "note");
  piece_view(page, file);
  for (const auto& [name, svg] : file.pictures)
    if (name.starts_with("roundness_")) page.picture(svg, name.substr(0, name.size() - 4));
  provenance(page, file);
}

EvidenceKind kind_of(const json& content) {
  const std::string format = text(content, "format");
  if (format == "trunnion-model") return EvidenceKind::model;
  if (format == "trunnion-closure") return EvidenceKind::closure;
  if (format == "trunnion-correction") return EvidenceKind::correction;
  if (format == "trunnion-prediction") return EvidenceKind::prediction;
  return content.is_object() && content.contains("controller") && content.contains("position_rms_um")
             ? EvidenceKind::tables
             : EvidenceKind::none;
}

std::string serial_of(const Result& file) { return text(part(file.content, "machine"), "serial"); }

}  // namespace

EvidenceKind evidence_kind(const std::string& text) { return kind_of(json::parse(text, nullptr, false)); }

std::string evidence_page(const std::vector<EvidenceFile>& files) {
  std::vector<Result> results;
  for (const EvidenceFile& file : files)
    results.push_back({file.path, json::parse(file.text, nullptr, false), file.tables, file.pictures});
  const auto of = [&](EvidenceKind kind) {
    std::vector<const Result*> found;
    for (const Result& file : results)
      if (kind_of(file.content) == kind) found.push_back(&file);
    return found;
  };
  for (const Result& file : results)
    if (serial_of(file) != serial_of(results.front()))
      throw InputError(file.path, "of machine " + serial_of(file) + ", but " + results.front().path +
                                      " is of machine " + serial_of(results.front()) + "; a page is of one machine");
  const json& machine = part(results.front().content, "machine");
  Page page(text(machine, "name") + ", serial " + text(machine, "serial"));
  page.section("summary", "In short", "");
  std::vector<std::vector<std::string>> rows = {{"", "before", "after", "unit"}};
  for (const Result* f : of(EvidenceKind::closure))
    rows.push_back({"closure: poses kept back (" + text(f->content, "verdict") + ")",
                    shown(number(part(f->content, "before"), "holdout_rms_um")),
                    shown(number(part(f->content, "after"), "holdout_rms_um")), "um rms"});
  for (const Result* f : of(EvidenceKind::tables))
    rows.push_back({"tables: " + text(f->content, "controller"),
                    shown(number(part(f->content, "position_rms_um"), "before")),
                    shown(number(part(f->content, "position_rms_um"), "tables")), "um rms"});
  for (const Result* f : of(EvidenceKind::correction))
    rows.push_back({"corrected program", shown(number(part(part(f->content, "playback"), "before"), "position_rms_um")),
                    shown(number(part(part(f->content, "playback"), "after"), "position_rms_um")), "um rms"});
  for (const Result* f : of(EvidenceKind::prediction))
    for (const char* variant : {"tables", "corrected"})
      if (f->content.contains(variant))
        rows.push_back({std::string("test piece, ") + variant,
                        shown(number(part(f->content, "uncompensated"), "rms_um")),
                        shown(number(part(f->content, variant), "rms_um")), "um rms"});
  page.table(rows, "The error before and after");
  for (const Result* f : of(EvidenceKind::model))
    if (part(part(f->content, "fit"), "method") != "closure") model_section(page, *f);
  for (const Result* f : of(EvidenceKind::closure)) closure_section(page, *f);
  if (!of(EvidenceKind::tables).empty()) tables_section(page, of(EvidenceKind::tables));
  for (const Result* f : of(EvidenceKind::correction)) correction_section(page, *f);
  for (const Result* f : of(EvidenceKind::prediction)) piece_section(page, *f);
  return page.html();
}

}  // namespace trunnion
