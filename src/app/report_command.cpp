#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "app/command.h"
#include "app/progress.h"
#include "error.h"
#include "io/csv.h"
#include "io/json_text.h"
#include "io/output_file.h"
#include "io/provenance.h"
#include "io/sha256.h"
#include "io/text_file.h"
#include "report/page.h"

namespace trunnion {
namespace report_cli {
namespace {

namespace fs = std::filesystem;

constexpr int kDeepest = 3;  ///< folders within folders

struct Options {
  std::vector<std::string> folders;
  std::string output, date;
};

std::string day_text(std::chrono::system_clock::time_point at) {
  const std::chrono::year_month_day day(std::chrono::floor<std::chrono::days>(at));
  char text[32];
  std::snprintf(text, sizeof text, "%04d-%02u-%02u", static_cast<int>(day.year()), static_cast<unsigned>(day.month()),
                static_cast<unsigned>(day.day()));
  return text;
}

/// What a command wrote with this content; nothing for JSON of another kind.
std::optional<ResultKind> kind_of(const nlohmann::json& content) {
  if (!content.is_object()) return std::nullopt;
  const std::string format = content.contains("format") && content["format"].is_string() ? content["format"] : "";
  if (format == "trunnion-model") return ResultKind::model;
  if (format == "trunnion-closure") return ResultKind::closure;
  if (format == "trunnion-correction") return ResultKind::correction;
  if (format == "trunnion-prediction") return ResultKind::prediction;
  if (content.contains("controller") && content.contains("lost_to")) return ResultKind::tables;
  return std::nullopt;
}

NumberColumns read_columns(const fs::path& path, std::vector<std::string>& inputs, TextColumns* labels = nullptr) {
  NumberColumns columns;
  if (!fs::is_regular_file(path)) return columns;
  inputs.push_back(path.string());
  const std::string text = read_text(path.string());
  CsvReader reader(text, path.string());
  std::vector<std::vector<double>*> places;
  std::vector<std::vector<std::string>> words(reader.header().size());
  std::vector<bool> is_text(reader.header().size(), false);
  for (const std::string& name : reader.header()) places.push_back(&columns[name]);
  std::vector<std::string_view> fields;
  while (reader.next(fields))
    for (std::size_t k = 0; k < places.size(); ++k) {
      const auto number = parse_number(fields[k]);
      places[k]->push_back(number.value_or(std::nan("")));
      is_text[k] = is_text[k] || (!number && !fields[k].empty());
      words[k].emplace_back(fields[k]);
    }
  for (std::size_t k = 0; labels != nullptr && k < words.size(); ++k)
    if (is_text[k]) (*labels)[reader.header()[k]] = std::move(words[k]);
  return columns;
}

/// As the page calls a file: from the folder that was given on.
std::string name_of(const fs::path& file, const fs::path& given) {
  const fs::path folder = fs::canonical(given);
  return fs::canonical(file).lexically_relative(folder.parent_path()).generic_string();
}

/// The JSON files of a folder and of those within, by name; a file stands for itself.
void gather(const fs::path& place, int depth, std::vector<fs::path>& files) {
  if (fs::is_regular_file(place)) {
    files.push_back(place);
    return;
  }
  std::vector<fs::path> entries;
  for (const fs::directory_entry& entry : fs::directory_iterator(place)) entries.push_back(entry.path());
  std::ranges::sort(entries);
  for (const fs::path& entry : entries)
    if (fs::is_regular_file(entry) ? entry.extension() == ".json" : fs::is_directory(entry) && depth < kDeepest)
      gather(entry, depth + 1, files);
}

std::optional<ResultFile> read_result(const fs::path& path, std::vector<std::string>& inputs) {
  const std::string text = read_text(path.string());
  auto content = std::make_shared<nlohmann::json>(parse_json(text, path.string()));
  const auto kind = kind_of(*content);
  if (!kind) return std::nullopt;
  inputs.push_back(path.string());
  ResultFile result{.kind = *kind,
                    .path = path.string(),
                    .sha256 = sha256_hex(text),
                    .changed = {},
                    .content = std::move(content),
                    .columns = {},
                    .labels = {},
                    .flank = {}};
  result.changed = day_text(std::chrono::time_point_cast<std::chrono::system_clock::duration>(
      std::chrono::file_clock::to_sys(fs::last_write_time(path))));
  if (*kind == ResultKind::closure)
    result.columns = read_columns(path.parent_path() / "residuals.csv", inputs, &result.labels);
  if (*kind == ResultKind::prediction) {
    result.columns = read_columns(path.parent_path() / "deviations.csv", inputs);
    result.flank = read_columns(path.parent_path() / "flank.csv", inputs);
  }
  return result;
}

int run(const Options& o, const Talk& talk) {
  Evidence evidence{.results = {}, .program = program_version(), .date = o.date};
  if (evidence.date.empty()) evidence.date = day_text(std::chrono::system_clock::now());
  std::vector<std::string> inputs;
  std::set<fs::path> seen;
  std::vector<std::vector<fs::path>> found;
  double total = 1;  // the page itself
  for (const std::string& folder : o.folders) {
    if (!fs::exists(folder)) throw InputError(folder, "no such folder");
    gather(folder, 0, found.emplace_back());
    total += static_cast<double>(found.back().size());
  }
  std::optional<Progress> progress(std::in_place, talk, "report", total, "files");
  double done = 0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const std::string& folder = o.folders[k];
    const std::vector<fs::path>& files = found[k];
    const std::size_t before = evidence.results.size();
    for (const fs::path& file : files) {
      progress->at(++done);
      if (!seen.insert(fs::canonical(file)).second) continue;
      if (auto result = read_result(file, inputs)) {
        result->path = name_of(file, folder);
        evidence.results.push_back(std::move(*result));
      } else if (talk.verbose) {
        talk.say(file.string() + ": no result of trunnion, passed over");
      }
    }
    if (evidence.results.size() == before)
      talk.warn(folder + ": nothing in it that a command of trunnion wrote; name the folders given to -o");
  }
  if (evidence.results.empty())
    throw InputError(o.folders.front(), "results of trunnion's commands are wanted, none found");
  const std::string page = page_html(evidence);
  progress.reset();
  write_whole(o.output, page, inputs);
  if (talk.json) {
    nlohmann::json summary = {
        {"format", "trunnion-report"}, {"version", 1}, {"page", o.output}, {"bytes", page.size()}};
    for (const ResultFile& r : evidence.results) summary["results"].push_back({{"path", r.path}, {"sha256", r.sha256}});
    std::fputs(json_text(summary).c_str(), stdout);
  }
  talk.say("wrote " + o.output + ", " + std::to_string(page.size() / 1000) + " kB from " +
           std::to_string(evidence.results.size()) + " results");
  return 0;
}

}  // namespace
}  // namespace report_cli

Command report_command(CLI::App& program, const Talk& talk) {
  using namespace report_cli;
  auto o = std::make_shared<Options>();
  CLI::App* app = program.add_subcommand("report", "One self-contained page from what the other commands wrote");
  app->add_option("folders", o->folders, "Folders of results (those within them too), or single result files")
      ->required()
      ->type_name("DIR")
      ->group("Input");
  app->add_option("-o,--output", o->output, "Page to write (HTML)")
      ->required()
      ->type_name("report.html")
      ->group("Output");
  app->add_option("--date", o->date, "Date on the page; default: today")->type_name("DATE")->group("Output");
  app->footer("Example:\n  trunnion report closed/ tables/ piece/ model.json -o report.html");
  return {app, [o, &talk] { return run(*o, talk); }};
}

}  // namespace trunnion
