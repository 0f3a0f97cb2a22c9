#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/command.h"
#include "error.h"
#include "io/csv.h"
#include "io/output_file.h"
#include "io/text_file.h"
#include "report/evidence.h"

namespace trunnion {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kLargest_bytes = 256U << 20U;

struct Options {
  std::vector<std::string> folders;
  std::string output;
};

NumberTable number_table(const std::string& path) {
  const std::string text = read_text(path);
  CsvReader csv(text, path);
  NumberTable table;
  std::vector<std::string_view> fields;
  while (csv.next(fields))
    for (std::size_t k = 0; k < fields.size(); ++k)
      table[csv.header()[k]].push_back(parse_number(fields[k]).value_or(std::nan("")));
  return table;
}

/// A JSON file that is a result of ours, with what lies beside it; empty for any other.
std::optional<EvidenceFile> evidence_in(const fs::path& path, const std::string& called) {
  EvidenceFile file{.path = called, .text = read_text(path.string())};
  const EvidenceKind kind = evidence_kind(file.text);
  if (kind == EvidenceKind::none) return std::nullopt;
  const auto beside = [&](const std::string& name) {
    if (const fs::path there = path.parent_path() / name; fs::is_regular_file(there))
      file.tables[name] = number_table(there.string());
  };
  if (kind == EvidenceKind::closure) beside("residuals.csv");
  if (kind == EvidenceKind::prediction) {
    beside("flank.csv");
    for (const auto& entry : fs::directory_iterator(path.parent_path()))
      if (entry.path().extension() == ".svg" && entry.path().filename().string().starts_with("roundness_"))
        file.pictures[entry.path().filename().string()] = read_text(entry.path().string());
  }
  return file;
}

int run(const Options& o, const Talk& talk) {
  std::vector<EvidenceFile> files;
  std::vector<std::string> inputs;
  for (const std::string& folder : o.folders) {
    std::vector<fs::path> found;
    if (fs::is_directory(folder)) {
      for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file() && entry.path().extension() == ".json" && entry.file_size() < kLargest_bytes)
          found.push_back(entry.path());
    } else if (fs::is_regular_file(folder)) {
      found.emplace_back(folder);
    } else {
      throw InputError(folder, "no such folder or file");
    }
    std::ranges::sort(found);
    for (const fs::path& path : found) {
      const std::string called =
          fs::is_directory(folder) ? fs::relative(path, folder).generic_string() : path.filename().string();
      if (auto file = evidence_in(path, called)) {
        files.push_back(std::move(*file));
        inputs.push_back(path.string());
      } else if (talk.verbose) {
        talk.say(path.string() + ": no result of trunnion, passed over");
      }
    }
  }
  if (files.empty())
    throw InputError(o.folders.front(), "no result of identify, close, tables, correct or predict in it");
  const std::string page = evidence_page(files);
  write_whole(o.output, page, inputs);
  if (talk.json)
    std::printf("%s\n",
                nlohmann::json({{"page", o.output}, {"results", inputs}, {"bytes", page.size()}}).dump(1).c_str());
  talk.say("wrote " + o.output + ": " + std::to_string(files.size()) + " results, " +
           std::to_string(page.size() / 1000) + " kB");
  return 0;
}

}  // namespace

Command report_command(CLI::App& program, const Talk& talk) {
  auto o = std::make_shared<Options>();
  CLI::App* app = program.add_subcommand("report", "One self-contained page from what the other commands wrote");
  app->add_option("DIR", o->folders, "Folders with results of one machine, or single result files")->required();
  app->add_option("-o,--output", o->output, "The page (HTML); opens without a network")
      ->required()
      ->type_name("report.html")
      ->group("Output");
  app->footer("Example:\n  trunnion report results closed -o report.html");
  return {app, [o, &talk] { return run(*o, talk); }};
}

}  // namespace trunnion
