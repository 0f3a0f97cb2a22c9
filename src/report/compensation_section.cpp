#include <cmath>
#include <nlohmann/json.hpp>

#include "report/chart.h"
#include "report/html.h"
#include "report/sections.h"

namespace trunnion {
namespace {

using nlohmann::json;

/// The number under the keys with unit; below a nanometre it says so.
std::string played(const json& j, const std::vector<std::string>& keys, const char* unit) {
  const auto value = number_at(j, keys);
  if (!value) return "–";
  if (*value == 0) return std::string("0\u00a0") + unit_symbol(unit);
  if (std::abs(*value) < 1e-3) return std::string("&lt;0.001\u00a0") + unit_symbol(unit);
  return quantity(*value, std::nullopt, unit);
}

std::string stages(const json& v, const char* key, const char* unit, const std::string& after) {
  return played(v, {key, "before"}, unit) + " → " + played(v, {key, after}, unit);
}

std::string volume_text(const json& v) {
  std::string text;
  if (v.contains("work_volume") && v["work_volume"].is_object())
    for (const auto& [key, range] : v["work_volume"].items())
      if (range.is_array() && range.size() == 2 && range[0].is_number() && range[1].is_number())
        text += (text.empty() ? "" : ", ") + key.substr(0, 1) + " " +
                quantity(range[0].get<double>(), std::nullopt, "") + " … " +
                quantity(range[1].get<double>(), std::nullopt, key.ends_with("_deg") ? "deg" : "mm");
  return text;
}

Chart along_chart(const json& along, const char* what, const char* unit) {
  const std::string symbol = unit_symbol(unit);
  Chart chart{.title = std::string("Deviation of the ") + what + " along the path",
              .x_label = "line of the program, count",
              .y_label = "deviation, " + symbol,
              .x_name = "line",
              .y_unit = symbol,
              .x = {},
              .series = {}};
  if (!along.contains("line") || !along["line"].is_array()) return chart;
  for (const json& line : along["line"]) chart.x.push_back(line.is_number() ? line.get<double>() : NAN);
  for (const char* stage : {"before", "after"}) {
    const std::string key = std::string(unit == std::string("um") ? "position_" : "orientation_") + stage + "_" + unit;
    if (!along.contains(key) || along[key].size() != chart.x.size()) continue;
    ChartSeries& series = chart.series.emplace_back(ChartSeries{stage, {}});
    for (const json& v : along[key]) series.values.push_back(v.is_number() ? v.get<double>() : NAN);
  }
  return chart;
}

/// "−7.26 … 28.0 mm" of a pair, "5.89 µm" of a number.
std::string span_text(const json& value, const std::string& unit) {
  if (value.is_number()) return quantity(value.get<double>(), std::nullopt, unit);
  if (!value.is_array() || value.size() != 2 || !value[0].is_number() || !value[1].is_number()) return "–";
  return quantity(value[0].get<double>(), std::nullopt, "") + " … " +
         quantity(value[1].get<double>(), std::nullopt, unit);
}

/// What the corrected program asks of each limit, and where it asks the most.
std::string limits_table(const json& playback) {
  if (!playback.contains("limits") || playback["limits"].empty()) return "";
  std::vector<std::vector<std::string>> rows;
  for (const json& use : playback["limits"]) {
    const std::string unit = text_at(use, "unit");
    const auto span = [&](const char* key) { return use.contains(key) ? span_text(use[key], unit) : std::string("–"); };
    std::string lines;
    for (const json& line : use.contains("lines") ? use["lines"] : json::array({use.value("line", 0)}))
      lines += (lines.empty() ? "" : ", ") + quantity(line.is_number() ? line.get<double>() : NAN, std::nullopt, "");
    rows.push_back({element("code", escaped(text_at(use, "limit"))), span("used"), span("allowed"), lines});
  }
  return html_table("Limits: what the corrected program uses of them", {"limit", "used", "allowed", "at line"}, rows);
}

/// What was left as it was, and why; empty where nothing was.
std::string left_uncorrected(const json& c) {
  std::string html;
  const json none = json::object();
  const json& p = c.contains("playback") ? c["playback"] : none;
  if (const double refused = number_at(p, {"refused_blocks"}).value_or(0); refused > 0) {
    const double from = number_at(p, {"copied_from_line"}).value_or(0);
    html += element("p",
                    quantity(refused, std::nullopt, "") + " refused blocks are copied as they were" +
                        (from > 0 ? ", and everything from line " + quantity(from, std::nullopt, "") + " on" : "") +
                        "; the numbers below are of the rest.",
                    "class=\"warning\"");
  }
  if (c.contains("refused") && !c["refused"].empty()) {
    std::vector<std::vector<std::string>> rows;
    for (const json& refusal : c["refused"])
      rows.push_back({quantity(refusal.value("line", 0), std::nullopt, ""), escaped(text_at(refusal, "reason"))});
    html += html_table("Refused blocks", {"line", "why"}, rows);
  }
  if (const double beyond = number_at(c, {"blocks_beyond_tolerance"}).value_or(0); beyond > 0)
    html += element("p",
                    "In " + quantity(beyond, std::nullopt, "") +
                        " blocks the tip is further off between the end points than the tolerance allows.",
                    "class=\"warning\"");
  return html;
}

}  // namespace

Section compensation_section(const Evidence& evidence) {
  Section section{"compensation", "Compensation by the control", ""};
  std::vector<std::vector<std::string>> rows, losses;
  std::string open;
  for (const ResultFile& r : evidence.results) {
    if (r.kind != ResultKind::tables) continue;
    const json& v = *r.content;
    const std::string name = escaped(text_at(v, "controller"));
    const bool ready = v.value("load_ready", false);
    rows.push_back({name, played(v, {"position_rms_um", "before"}, "um"), played(v, {"position_rms_um", "ideal"}, "um"),
                    played(v, {"position_rms_um", "tables"}, "um"), stages(v, "position_max_um", "um", "tables"),
                    stages(v, "orientation_rms_urad", "urad", "tables"), ready ? "yes" : "no, drafts"});
    losses.push_back({name, played(v, {"lost_to", "format"}, "um"), played(v, {"lost_to", "spacing"}, "um"),
                      played(v, {"lost_to", "quantisation"}, "um"),
                      quantity(number_at(v, {"spacing_deg"}).value_or(NAN), std::nullopt, "deg"), volume_text(v)});
    if (v.contains("unconfirmed") && !v["unconfirmed"].empty())
      open += element(
          "p",
          name + ": not to be loaded before the commissioning test has answered: " + word_list(v["unconfirmed"]) + ".",
          "class=\"warning\"");
    section.sentence += (section.sentence.empty() ? "" : " ") + std::string("Tables for ") + name + ": <strong>" +
                        stages(v, "position_rms_um", "um", "tables") + "</strong> rms in the working volume" +
                        (ready ? "." : " (drafts).");
  }
  if (rows.empty()) return {};
  section.html =
      open +
      html_table(
          "Deviation in the working volume: as the machine is, as the model could, as the control plays it",
          {"controller", "before, rms", "ideal, rms", "as played, rms", "largest", "orientation, rms", "load-ready"},
          rows) +
      html_table("What the tables lose, and to what (rms)",
                 {"controller", "format", "spacing", "quantisation", "nodes every", "working volume"}, losses);
  return section;
}

Section program_section(const Evidence& evidence) {
  Section section{"program", "Program correction", ""};
  for (const ResultFile& r : evidence.results) {
    if (r.kind != ResultKind::correction) continue;
    const json& c = *r.content;
    const std::string name = text_at(c, "nc_program", r.path);
    const auto count = [&](const char* key) { return quantity(number_at(c, {key}).value_or(0), std::nullopt, ""); };
    const auto counted = [&](const char* key, const std::string& one, const std::string& done) {
      return count(key) + " " + one + (count(key) == "1" ? " " : "s ") + done;
    };
    section.html += element("h3", escaped(name)) +
                    element("p", counted("corrected_blocks", "move", "of ") + counted("lines", "line", "corrected, ") +
                                     counted("changed_words", "word", "changed, ") + count("added_words") + " added, " +
                                     counted("inserted_blocks", "block", "inserted, ") +
                                     counted("copied_moves", "move", "copied. ") + "Dialect " +
                                     escaped(text_at(c, "dialect", "not said")) + ", tool-centre-point control " +
                                     escaped(text_at(c, "tcp", "not said")) + ".");
    section.html += left_uncorrected(c);
    if (!c.contains("playback")) continue;
    const json& p = c["playback"];
    std::vector<std::vector<std::string>> rows;
    for (const char* stage : {"before", "after"})
      rows.push_back({stage, played(p, {stage, "position_rms_um"}, "um"), played(p, {stage, "position_max_um"}, "um"),
                      played(p, {stage, "orientation_rms_urad"}, "urad"),
                      played(p, {stage, "orientation_max_urad"}, "urad")});
    section.html += html_table("Played back on the machine with its errors",
                               {"", "tip, rms", "tip, largest", "tool axis, rms", "tool axis, largest"}, rows);
    section.html += limits_table(p);
    std::string figures;
    if (p.contains("along"))
      for (const Chart& chart : {along_chart(p["along"], "tip", "um"), along_chart(p["along"], "tool axis", "urad")})
        if (chart.series.size() == 2 && chart.x.size() > 1) figures += chart_figure(chart);
    section.html += element("div", figures, "class=\"charts\"");
    section.sentence += (section.sentence.empty() ? "" : " ") +
                        std::string("A corrected program meets its path to <strong>") +
                        played(p, {"before", "position_rms_um"}, "um") + " → " +
                        played(p, {"after", "position_rms_um"}, "um") + "</strong> rms.";
  }
  return section.html.empty() ? Section{} : section;
}

}  // namespace trunnion
