#include "app/fleet.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "error.h"
#include "io/csv.h"
#include "io/json_text.h"
#include "io/sha256.h"
#include "io/text_file.h"

namespace trunnion {

using nlohmann::json;

namespace {

constexpr std::size_t kFingerprintDigits = 16;

/// A number of a result, or null where it does not have it.
json at(const json& result, const std::string& pointer) {
  const json::json_pointer place(pointer);
  return result.contains(place) ? result[place] : json();
}

json summary_of_model(const json& model) {
  json s = {{"reduced_chi2", at(model, "/fit/reduced_chi2")}, {"sigma_found_um", at(model, "/fit/sigma_found_um")}};
  if (const json outliers = at(model, "/fit/outliers"); outliers.is_array()) s["outliers"] = outliers.size();
  const json locations = at(model, "/fit/location_errors/values");
  for (const auto& [symbol, found] : locations.items())
    s[symbol + "_" + found.value("unit", "")] = found.value("value", json());
  const json errors = at(model, "/fit/errors");
  for (const auto& [symbol, found] : errors.items())
    s[symbol + "_largest_" + found.value("unit", "")] = found.value("largest", json());
  return s;
}

json summary_of_piece(const json& prediction) {
  json s = json::object();
  for (const auto& [name, cut] : prediction.items()) {
    if (!cut.is_object() || !cut.contains("heights") || !cut.contains("rms_um")) continue;
    s[name + "_rms_um"] = cut["rms_um"];
    double lsc = 0;
    for (const json& height : cut["heights"]) lsc = std::max(lsc, height.value("lsc_um", 0.0));
    s[name + "_lsc_um"] = lsc;
  }
  return s;
}

/// The last line on a job's standard error.
std::string said(const BatchJob& job) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(job.stem + ".log", ignored)) return "";
  std::string text = read_text(job.stem + ".log");
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text.substr(text.find_last_of('\n') + 1);
}

/// What people compare machines by.
json summary_of(const BatchJob& job, const json& result) {
  switch (job.kind) {
    case JobKind::identify:
      return summary_of_model(result);
    case JobKind::tables:
      return {{"load_ready", at(result, "/load_ready")},
              {"before_um", at(result, "/position_rms_um/before")},
              {"tables_um", at(result, "/position_rms_um/tables")},
              {"tables_max_um", at(result, "/position_max_um/tables")}};
    case JobKind::correct:
      return {{"largest_deviation_um", at(result, "/largest_deviation_um")},
              {"refused", at(result, "/refused").size()},
              {"before_max_um", at(result, "/playback/before/position_max_um")},
              {"after_max_um", at(result, "/playback/after/position_max_um")}};
    case JobKind::predict:
      return summary_of_piece(result);
  }
  return {};
}

}  // namespace

std::vector<std::string> fingerprints(const std::vector<BatchJob>& jobs, const JobsDone& progress) {
  std::map<std::string, std::string> digits_of;  // programs and pieces are shared by all machines
  std::vector<std::string> all;
  for (const BatchJob& job : jobs) {
    std::string text;
    const auto add = [&](const std::string& part) { text += std::to_string(part.size()) + ":" + part; };
    for (const std::string& word : job.words) add(word);
    for (const std::string& input : job.inputs) {
      std::string& digits = digits_of[input];
      if (digits.empty()) digits = sha256_hex(read_text(input));
      add(digits);
    }
    for (const std::size_t earlier : job.after) add(all[earlier]);
    all.push_back(sha256_hex(text).substr(0, kFingerprintDigits));
    if (progress) progress(all.size());
  }
  return all;
}

std::optional<int> job_status(const BatchJob& job, const std::string& fingerprint) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(job.stem + ".status", ignored)) return std::nullopt;
  const std::string text = read_text(job.stem + ".status");
  int status = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), status);
  if (error == std::errc() && std::string_view(end, text.data() + text.size()) == " " + fingerprint + "\n")
    return status;
  return std::nullopt;
}

json fleet_json(const BatchPlan& plan, const std::vector<BatchJob>& jobs, const std::vector<std::string>& fingerprints,
                const JobsDone& progress) {
  json fleet = {{"format", "trunnion-fleet"}, {"version", 1}, {"missing", json::array()}};
  std::map<std::string, json> machines;
  for (std::size_t k = 0; k < jobs.size(); ++k) {
    const BatchJob& job = jobs[k];
    const std::optional<int> status = job_status(job, fingerprints[k]);
    json entry = {{"job", job.label}, {"status", status ? json(*status) : json()}};
    if (!is_done(status)) {
      fleet["missing"].push_back({{"job", job.name()}, {"status", entry["status"]}, {"said", status ? said(job) : ""}});
    } else {
      std::error_code ignored;
      if (std::filesystem::is_regular_file(job.result, ignored))
        entry["found"] = summary_of(job, parse_json(read_text(job.result), job.result));
    }
    machines[job.machine].push_back(std::move(entry));
    if (progress) progress(k + 1);
  }
  fleet["machines"] = json::array();
  for (const BatchMachine& machine : plan.machines)
    fleet["machines"].push_back({{"name", machine.name}, {"jobs", machines[machine.name]}});
  return fleet;
}

std::string fleet_csv(const json& fleet) {
  std::vector<std::string> columns;
  std::map<std::string, std::map<std::string, std::string>> rows;
  for (const json& machine : fleet["machines"])
    for (const json& job : machine["jobs"]) {
      const std::string label = job["job"];
      const auto put = [&](const std::string& column, const json& value) {
        if (std::ranges::find(columns, column) == columns.end()) columns.push_back(column);
        std::string text;
        if (value.is_boolean()) text = value.get<bool>() ? "1" : "0";
        if (value.is_number()) append_number(text, value.get<double>());
        rows[machine["name"]][column] = text;
      };
      put(label + ".status", job["status"]);
      if (job.contains("found"))
        for (const auto& [key, value] : job["found"].items()) put(label + "." + key, value);
    }
  std::string text = "machine";
  for (const std::string& column : columns) text += "," + column;
  text += "\n";
  for (const json& machine : fleet["machines"]) {
    const std::string name = machine["name"];
    text += name;
    for (const std::string& column : columns) text += "," + rows[name][column];
    text += "\n";
  }
  return text;
}

}  // namespace trunnion
