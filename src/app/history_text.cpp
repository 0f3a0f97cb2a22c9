#include "app/history_text.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/text_table.h"
#include "history/date.h"
#include "io/csv.h"
#include "units/number_text.h"

namespace trunnion {

using nlohmann::json;

namespace {

constexpr double kBand95 = 1.959963984540054;  // standard deviations

/// Functions of the tilting axis have no C.
bool of_turn(const std::string& error, char tilt) { return error.back() != tilt; }

std::string place_text(const std::string& error, const std::optional<IndexedPosition>& at, char tilt) {
  if (!at) return "";
  std::string text = std::string(1, tilt) + formatted(" %.6g", at->a.in_degrees());
  if (of_turn(error, tilt)) text += formatted(" C %.6g", at->c.in_degrees());
  return text;
}

void add_place(json& entry, const std::string& error, const std::optional<IndexedPosition>& at, char tilt) {
  if (!at) return;
  entry[std::string(1, tilt) + "_deg"] = at->a.in_degrees();
  if (of_turn(error, tilt)) entry["C_deg"] = at->c.in_degrees();
}

std::optional<IndexedPosition> place_of(const ErrorSeries& series, std::size_t k) {
  if (series.places.empty()) return std::nullopt;
  return series.places[k];
}

double std_of(const ErrorSeries::Point& point, Eigen::Index k) {
  return std::sqrt(std::max(0.0, point.covariance(k, k)));
}

const std::string& date_of(const MachineHistory& history, const ErrorSeries& series, std::size_t point) {
  return history.calibrations[series.points[point].calibration].taken;
}

/// The closure as it was stored; null where there is none or it cannot be read.
json closure_of(const Calibration& calibration) {
  return calibration.closure ? json::parse(*calibration.closure, nullptr, false) : json();
}

std::string verdict_of(const Calibration& calibration) {
  const json closure = closure_of(calibration);
  return closure.is_object() ? closure.value("verdict", "") : "";
}

std::vector<const ErrorSeries*> shown_series(const SeriesSet& set) {
  std::vector<const ErrorSeries*> all;
  for (const auto* kind : {&set.locations, &set.functions, &set.parameters})
    for (const ErrorSeries& series : *kind) all.push_back(&series);
  return all;
}

}  // namespace

json calibration_json(const Calibration& c) {
  json inputs = json::object();
  for (const auto& [name, sha256] : c.inputs) inputs[name] = sha256;
  json j = {{"id", c.id},
            {"machine", {{"name", c.machine.name}, {"serial", c.machine.serial}, {"structure", c.machine.structure}}},
            {"taken", c.taken},
            {"model_sha256", c.model_sha256},
            {"inputs_sha256", std::move(inputs)},
            {"note", c.note}};
  if (const json closure = closure_of(c); closure.is_object()) j["closure"] = closure;
  return j;
}

std::string calibration_table(const std::vector<Calibration>& calibrations) {
  std::vector<std::vector<std::string>> rows = {{"serial", "id", "taken", "verdict", "model", "note"}};
  for (const Calibration& c : calibrations)
    rows.push_back({c.machine.serial, std::to_string(c.id), short_date(c.taken), verdict_of(c),
                    c.model_sha256.substr(0, 12), c.note});
  return text_table(rows);
}

std::string calibration_text(const Calibration& c) {
  std::string text = "Calibration " + std::to_string(c.id) + " of " + c.machine.name + ", serial " + c.machine.serial +
                     ", structure " + c.machine.structure + "\nTaken " + c.taken + "\n";
  if (!c.note.empty()) text += "Note: " + c.note + "\n";
  text += "Model " + c.model_sha256 + "\n";
  for (const auto& [name, sha256] : c.inputs) text += "Made from " + name + " " + sha256 + "\n";
  const json closure = closure_of(c);
  if (!closure.is_object()) return text;
  text += "Closure: " + closure.value("verdict", "") + "\n";
  for (const json& effect : closure.value("effects", json::array()))
    text += "  " + effect.value("id", "") + " (of the " + effect.value("origin", "") + ")\n";
  return text;
}

std::string trend_text(const MachineHistory& h) {
  const char tilt = h.machine.tilt_letter();
  std::vector<std::vector<std::string>> rows = {{"error", "at", "first", "last", "changed by", "unit"}};
  for (const ErrorSeries* series : shown_series(h.series)) {
    const ErrorSeries::Point &first = series->points.front(), &last = series->points.back();
    Eigen::Index k = 0;
    last.values.cwiseAbs().maxCoeff(&k);
    const auto in_unit = [&](double value) { return to_unit(value, series->unit); };
    const double s0 = in_unit(std_of(first, k)), s1 = in_unit(std_of(last, k));
    rows.push_back({series->name, place_text(series->name, place_of(*series, static_cast<std::size_t>(k)), tilt),
                    with_uncertainty(in_unit(first.values[k]), s0), with_uncertainty(in_unit(last.values[k]), s1),
                    with_uncertainty(in_unit(last.values[k] - first.values[k]), std::hypot(s0, s1)),
                    std::string(unit_text(series->unit).text)});
  }
  return std::to_string(h.models.size()) + " calibrations from " + short_date(h.calibrations.front().taken) + " to " +
         short_date(h.calibrations.back().taken) + "; functions where the last is largest\n" + text_table(rows);
}

std::string trend_csv(const MachineHistory& h) {
  const char tilt = h.machine.tilt_letter();
  std::string text = std::string("taken,calibration,error,") + tilt + "_deg,C_deg,value,std,low,high,unit\n";
  const auto number = [&](double value) {
    append_number(text, value);
    text += ',';
  };
  for (const ErrorSeries* series : shown_series(h.series))
    for (std::size_t p = 0; p < series->points.size(); ++p) {
      const ErrorSeries::Point& point = series->points[p];
      for (Eigen::Index k = 0; k < point.values.size(); ++k) {
        text += date_of(h, *series, p) + "," + std::to_string(h.calibrations[point.calibration].id) + "," +
                series->name + ",";
        const auto at = place_of(*series, static_cast<std::size_t>(k));
        if (at) append_number(text, std::round(1e6 * at->a.in_degrees()) / 1e6);
        text += ',';
        if (at && of_turn(series->name, tilt)) append_number(text, std::round(1e6 * at->c.in_degrees()) / 1e6);
        text += ',';
        const double value = to_unit(point.values[k], series->unit);
        const double std = to_unit(std_of(point, k), series->unit);
        number(value), number(std), number(value - kBand95 * std), number(value + kBand95 * std);
        text += std::string(unit_text(series->unit).text) + "\n";
      }
    }
  return text;
}

json alarm_json(const Alarm& a, char tilt) {
  json j = {{"error", a.error},
            {"of", a.of_change ? "change" : "value"},
            {"found", a.found},
            {"std", a.std},
            {"limit", a.limit},
            {"proven", a.proven},
            {"unit", unit_text(a.unit).text}};
  add_place(j, a.error, a.at, tilt);
  return j;
}

std::string alarm_text(const Alarm& a, char tilt) {
  const std::string place = place_text(a.error, a.at, tilt);
  const std::string unit(unit_text(a.unit).text);
  return a.error + (place.empty() ? "" : " at " + place) + (a.of_change ? " has changed by " : ": ") +
         with_uncertainty(a.found, a.std) + " " + unit + ", the limit is " + formatted("%.6g ", a.limit) + unit +
         (a.proven ? "" : " (within two standard uncertainties of it)");
}

namespace {

/// The calibration that a point of the problem is.
const std::string& date_of(const MachineHistory& h, const std::vector<ErrorSeries::Point>& points, std::size_t k) {
  return h.calibrations[points[k].calibration].taken;
}

std::optional<IndexedPosition> place_of(const Change& change) {
  if (change.places.empty()) return std::nullopt;
  return change.places[change.largest];
}

std::string change_text(const MachineHistory& h, const std::vector<ErrorSeries::Point>& points, const Change& change) {
  const auto k = static_cast<Eigen::Index>(change.largest);
  const std::string place = place_text(change.error, place_of(change), h.machine.tilt_letter());
  const auto date = [&](std::size_t point) { return short_date(date_of(h, points, point)); };
  std::string text = change.error + (change.drift ? " drifts by " : " moved by ") +
                     with_uncertainty(to_unit(change.amount[k], change.unit), to_unit(change.std[k], change.unit)) +
                     " " + std::string(unit_text(change.unit).text) + (change.drift ? " a year" : "") +
                     (place.empty() ? "" : " at " + place);
  text += change.drift ? ", since " + date(change.from) : ", between " + date(change.from) + " and " + date(change.to);
  if (change.earliest != change.latest)
    text += " (with 95 %: " + date(change.earliest) + " to " + date(change.latest + (change.drift ? 0 : 1)) + ")";
  return text + formatted(", p %.1e\n", change.p_value);
}

json change_json(const MachineHistory& h, const std::vector<ErrorSeries::Point>& points, const Change& change) {
  const char tilt = h.machine.tilt_letter();
  const std::string unit = std::string(unit_text(change.unit).text) + (change.drift ? "/year" : "");
  json j = {{"error", change.error},
            {"kind", change.drift ? "drift" : "step"},
            {"from", date_of(h, points, change.from)},
            {"to", date_of(h, points, change.to)},
            {"from_earliest", date_of(h, points, change.earliest)},
            {"from_latest", date_of(h, points, change.latest)},
            {"p_value", change.p_value},
            {"unit", unit},
            {"places", json::array()}};
  for (Eigen::Index k = 0; k < change.amount.size(); ++k) {
    json entry = {{"amount", to_unit(change.amount[k], change.unit)}, {"std", to_unit(change.std[k], change.unit)}};
    if (!change.places.empty()) add_place(entry, change.error, change.places[static_cast<std::size_t>(k)], tilt);
    j["places"].push_back(std::move(entry));
  }
  j["largest"] = j["places"][change.largest];
  return j;
}

json course_json(const MachineHistory& h, const std::vector<ErrorSeries::Point>& points, const CourseFinding& course) {
  json j = {{"p_value", course.p_value},
            {"left_p_value", course.left_p_value},
            {"scatter", course.scatter},
            {"changes", json::array()}};
  for (const Change& change : course.changes) j["changes"].push_back(change_json(h, points, change));
  return j;
}

std::string rest_text(const CourseFinding& course, const std::string& what) {
  if (course.scatter > 1)
    return what + formatted(" scatter %.1f times as much as the uncertainties say", course.scatter) +
           formatted(" (p %.1e)\n", course.left_p_value);
  return what + formatted(" agree within the uncertainties (p %.2g)\n", course.left_p_value);
}

}  // namespace

std::string comparison_text(const MachineHistory& h) {
  const char tilt = h.machine.tilt_letter();
  std::vector<std::vector<std::string>> rows = {{"error", short_date(h.calibrations[0].taken),
                                                 short_date(h.calibrations[1].taken), "difference", "unit", "at", "p",
                                                 "differs"}};
  for (const ErrorSeries* series : shown_series(h.series)) {
    const Difference d = difference(*series);
    const auto shown = [&](double value, double std) {
      return with_uncertainty(to_unit(value, series->unit), to_unit(std, series->unit));
    };
    rows.push_back({series->name, shown(d.before, d.before_std), shown(d.after, d.after_std),
                    shown(d.after - d.before, std::hypot(d.before_std, d.after_std)),
                    std::string(unit_text(series->unit).text),
                    place_text(series->name, place_of(*series, d.largest), tilt), formatted("%.1e", d.p_value),
                    d.p_value < kTold ? "yes" : "no"});
  }
  return "Functions where they differ most, in standard uncertainties\n" + text_table(rows);
}

json comparison_json(const MachineHistory& h) {
  json j = {{"format", "trunnion-comparison"}, {"version", 1}, {"errors", json::array()}};
  j["calibrations"] = {calibration_json(h.calibrations[0]), calibration_json(h.calibrations[1])};
  for (const ErrorSeries* series : shown_series(h.series)) {
    const Difference d = difference(*series);
    json entry = {{"error", series->name},
                  {"before", to_unit(d.before, series->unit)},
                  {"before_std", to_unit(d.before_std, series->unit)},
                  {"after", to_unit(d.after, series->unit)},
                  {"after_std", to_unit(d.after_std, series->unit)},
                  {"unit", unit_text(series->unit).text},
                  {"p_value", d.p_value},
                  {"differs", d.p_value < kTold}};
    add_place(entry, series->name, place_of(*series, d.largest), h.machine.tilt_letter());
    j["errors"].push_back(std::move(entry));
  }
  return j;
}

std::string drift_text(const MachineHistory& h, const CourseFinding& course,
                       const std::vector<CourseFinding>& parameters) {
  std::string text = std::to_string(h.models.size()) + " calibrations from " +
                     short_date(h.calibrations.front().taken) + " to " + short_date(h.calibrations.back().taken) + "\n";
  for (const Change& change : course.changes) text += change_text(h, h.series.poses.points, change);
  text += rest_text(course, course.changes.empty() ? "All calibrations" : "But for that, all calibrations");
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const ErrorSeries& series = h.series.parameters[k];
    for (const Change& change : parameters[k].changes) text += change_text(h, series.points, change);
    text += rest_text(parameters[k], series.name + (parameters[k].changes.empty() ? ": all" : ": but for that, all"));
  }
  return text;
}

json drift_json(const MachineHistory& h, const CourseFinding& course, const std::vector<CourseFinding>& parameters) {
  json j = {{"format", "trunnion-drift"}, {"version", 1}, {"notes", h.notes}};
  j["machine"] = {{"name", h.machine.name}, {"serial", h.machine.serial}};
  j["calibrations"] = json::array();
  for (const Calibration& c : h.calibrations) j["calibrations"].push_back({{"id", c.id}, {"taken", c.taken}});
  j["rotary_errors"] = course_json(h, h.series.poses.points, course);
  j["parameters"] = json::object();
  for (std::size_t k = 0; k < parameters.size(); ++k)
    j["parameters"][h.series.parameters[k].name] = course_json(h, h.series.parameters[k].points, parameters[k]);
  return j;
}

}  // namespace trunnion
