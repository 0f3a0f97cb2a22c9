#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "app/changed_inputs.h"
#include "app/command.h"
#include "app/progress.h"
#include "compensation/verification.h"
#include "error.h"
#include "io/machine_file.h"
#include "io/model_file.h"
#include "io/output_file.h"
#include "io/provenance.h"
#include "io/sha256.h"
#include "io/text_file.h"

namespace trunnion {
namespace tables_cli {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string machine, model, controller, output, date;
  double spacing_deg = 0, tool_length_mm = 0;
};

/// The files of a set that stands in `folder` already, as its verification.json lists them; none if there is no set.
std::set<std::string> standing_set(const fs::path& folder) {
  std::set<std::string> names;
  const fs::path summary = folder / "verification.json";
  if (!fs::is_regular_file(summary)) return names;
  const auto json = nlohmann::json::parse(read_text(summary.string()), nullptr, false);
  if (json.is_discarded() || !json.is_object() || !json.contains("controller") || !json.contains("files")) return names;
  for (const auto& entry : json["files"]) {
    if (!entry.is_string()) continue;
    const fs::path name = entry.get<std::string>();
    const bool inside = !name.is_absolute() && name.lexically_normal().string().rfind("..", 0) != 0;
    if (inside) names.insert(name.generic_string());
  }
  for (const char* name : {"verification.json", "verification.txt", "LOADING.md", "COMMISSIONING.md"})
    names.insert(name);
  const fs::path small = folder / "commissioning";
  if (fs::is_directory(small))
    for (const fs::directory_entry& entry : fs::directory_iterator(small))
      if (const std::string name = entry.path().filename().string(); name.find(".DRAFT.") != std::string::npos)
        names.insert("commissioning/" + name);
  return names;
}

void remove_all_of(const fs::path& folder, const std::set<std::string>& names) {
  std::error_code ignored;
  for (const std::string& name : names) fs::remove(folder / name, ignored);
  for (const char* empty : {"kinematics", "joint_tables", "commissioning"})
    if (fs::is_directory(folder / empty, ignored) && fs::is_empty(folder / empty, ignored))
      fs::remove(folder / empty, ignored);
}

TableOptions table_options(const Options& o) {
  const auto spacing = [](double degrees, const char* option) {
    if (degrees != 0 && !(degrees >= 0.1 && degrees <= 90))
      throw UsageError(std::string(option) + ": 0.1 to 90 deg is wanted");
    return Angle::degrees(degrees);
  };
  if (!std::isfinite(o.tool_length_mm) || std::abs(o.tool_length_mm) > 10000)
    throw UsageError("--tool-length: a length in mm is wanted");
  for (const char letter : o.date)
    if (static_cast<unsigned char>(letter) < ' ') throw UsageError("--date: one line of text is wanted");
  TableOptions options;
  options.date = o.date;
  options.turn_spacing = options.tilt_spacing = spacing(o.spacing_deg, "--spacing");
  options.tool_length = Length::millimetres(o.tool_length_mm);
  return options;
}

int run(const Options& o, const Talk& talk) {
  const Machine machine = read_machine(o.machine);
  const Model model = read_model(o.model, machine);
  for (const std::string& line : changed_inputs(model, o.model, {o.machine})) talk.warn(line);
  const std::string name = o.controller.empty() ? machine.controller : o.controller;
  if (name.empty()) throw UsageError("--controller: missing, and the machine file names none");
  const Controller& controller = controller_named(name);
  const TableOptions options = table_options(o);
  for (const std::string& column : needed_covariates(model))
    if (!column.ends_with("_dir")) talk.warn("the model depends on " + column + ": the tables hold for its zero");

  const std::set<std::string> before = standing_set(o.output);
  TableSet set;
  try {
    Progress progress(talk, "tables for " + std::string(controller.name));
    set = make_tables(controller, machine, model, options, [&](const std::string& step) { progress.now(step); });
  } catch (const Error&) {
    remove_all_of(o.output, before);  // nothing load-ready is left of an earlier set either
    throw;
  }
  OutputFolder folder(o.output, {o.machine, o.model});
  std::set<std::string> stale = before;
  const nlohmann::json provenance = provenance_json({o.machine, o.model});
  nlohmann::ordered_json digests = nlohmann::ordered_json::object();
  for (const TableFile& file : set.files)
    if (std::ranges::find(set.verification.files, file.name) != set.verification.files.end())
      digests[file.name] = sha256_hex(file.text);
  for (TableFile& file : set.files) {
    if (file.name == "verification.json") {
      auto summary = nlohmann::ordered_json::parse(file.text);
      summary["files_sha256"] = digests;
      summary.update(nlohmann::ordered_json(provenance));
      file.text = summary.dump(2) + "\n";
      if (talk.json) std::fputs(file.text.c_str(), stdout);
    }
    folder.add(file.name, file.text);
    stale.erase(file.name);
  }
  folder.commit();
  remove_all_of(o.output, stale);

  const Verification& v = set.verification;
  talk.show(verification_text(v, machine));
  talk.say("wrote " + std::to_string(set.files.size()) + " files to " + o.output);
  if (v.load_ready()) return 0;
  std::string keys;
  for (const std::string& key : v.unconfirmed) keys += (keys.empty() ? "" : ", ") + key;
  throw RefusalError(std::string(controller.name) + ": not load-ready, the machine file's [profile] does not confirm " +
                     keys + "; drafts and the commissioning test are in " + o.output);
}

}  // namespace
}  // namespace tables_cli

Command tables_command(CLI::App& program, const Talk& talk) {
  using namespace tables_cli;
  auto o = std::make_shared<Options>();
  CLI::App* app = program.add_subcommand("tables", "The controller's compensation files, read back and verified");
  app->add_option("--machine", o->machine, "Machine file (TOML)")->required()->type_name("M.toml")->group("Input");
  app->add_option("--model", o->model, "Model (JSON)")->required()->type_name("model.json")->group("Input");
  app->add_option("--controller", o->controller, "Controller; the machine file's if left out")
      ->type_name("NAME")
      ->group("Tables");
  app->add_option("--date", o->date, "Date for the headers")->type_name("DATE")->group("Tables");
  app->add_option("--spacing", o->spacing_deg, "Distance of nodes, deg; chosen for the error if left out")
      ->type_name("DEG")
      ->group("Tables");
  app->add_option("--tool-length", o->tool_length_mm, "Tool that tables over the Z axis assume, mm")
      ->type_name("MM")
      ->group("Tables");
  app->add_option("-o,--output", o->output, "Folder to write")->required()->type_name("DIR")->group("Output");
  std::string names;
  for (const Controller& controller : controllers())
    names += (names.empty() ? "" : ", ") + std::string(controller.name);
  app->footer("Controllers: " + names +
              ".\nExit status 1, and files named *.DRAFT.*, while the machine file's [profile] leaves a question about "
              "the control open.\n"
              "Example:\n  trunnion tables --machine machine.toml --model model.json --controller linuxcnc -o tables/");
  return {app, [o, &talk] { return run(*o, talk); }};
}

}  // namespace trunnion
