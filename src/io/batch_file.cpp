#include "io/batch_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "error.h"
#include "io/text_file.h"
#include "io/toml_reader.h"

namespace trunnion {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargestPlan_bytes = std::size_t{1} << 24;
constexpr double kMostDraws = 1e6;

/// Names become file names, columns and lines of a shell.
bool usable_name(const std::string& name) {
  return !name.empty() && name[0] != '.' && name[0] != '-' && std::ranges::none_of(name, [](char c) {
    return static_cast<unsigned char>(c) < ' ' || c == '/' || c == ',' || c == '"' || c == '\\';
  });
}

double whole_number(TomlReader& table, const std::string& key, double most, double otherwise) {
  const double value = table.number(key).value_or(otherwise);
  if (value < 0 || value != std::floor(value) || value > most)
    table.fail(key, "a whole number from 0 to " + std::to_string(static_cast<std::int64_t>(most)) + " is wanted");
  return value;
}

/// The `name` of a [[program]] or [[piece]], unlike the others'.
std::string unique_name(TomlReader& table, std::set<std::string>& seen) {
  const std::string name = table.required_text("name");
  if (!usable_name(name)) table.fail("name", "a name that can be part of a file's is wanted");
  if (!seen.insert(name).second) table.fail("name", "\"" + name + "\" occurs twice");
  return name;
}

/// `file` as told from `folder`; a plan lies beside what it names.
std::string beside(const fs::path& folder, const std::string& file) {
  return (folder / file).lexically_normal().generic_string();
}

BatchMachine machine_in(const fs::path& folder, const std::string& plan) {
  BatchMachine machine{.name = folder.filename().string(), .machine_file = (folder / "machine.toml").generic_string()};
  if (!usable_name(machine.name))
    throw InputError(plan, "machines.folder: \"" + machine.name + "\" cannot name results");
  std::error_code ignored;
  if (!fs::is_regular_file(folder / "machine.toml", ignored))
    throw InputError(folder.string(), "machine.toml is missing, each folder below machines.folder is one machine");
  const bool observed = fs::is_regular_file(folder / "observations.csv", ignored);
  const bool modelled = fs::is_regular_file(folder / "model.json", ignored);
  if (observed == modelled)
    throw InputError(folder.string(), std::string(observed ? "both of" : "neither of") +
                                          " observations.csv and model.json found, one of them is wanted");
  (observed ? machine.observations : machine.model) =
      (folder / (observed ? "observations.csv" : "model.json")).generic_string();
  return machine;
}

std::vector<BatchMachine> read_machines(TomlReader& top, const fs::path& folder, const std::string& plan) {
  auto table = top.table("machines");
  if (!table) top.fail("machines", "the table [machines] is missing");
  const fs::path parent = (folder / table->required_text("folder")).lexically_normal();
  std::vector<std::string> names = table->texts("names");
  table->finish();
  if (names.empty()) {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(parent, error))
      if (entry.is_directory()) names.push_back(entry.path().filename().string());
    if (error) throw InputError(parent.string(), "cannot be read: " + error.message());
  }
  std::ranges::sort(names);
  if (const auto twice = std::ranges::adjacent_find(names); twice != names.end())
    throw InputError(plan, "machines.names: \"" + *twice + "\" occurs twice");
  std::vector<BatchMachine> machines;
  for (const std::string& name : names) machines.push_back(machine_in(parent / name, plan));
  if (machines.empty()) throw InputError(parent.string(), "no machines in it: a folder for each is wanted");
  return machines;
}

}  // namespace

BatchPlan read_batch_plan(const std::string& path) {
  const toml::table document = TomlReader::parse(read_text(path, kLargestPlan_bytes), path);
  const fs::path folder = fs::path(path).parent_path();
  TomlReader top(document, path, "");
  top.check_format("trunnion-batch");
  BatchPlan plan;
  plan.seed = static_cast<std::uint64_t>(whole_number(top, "seed", 1e9, 1));
  plan.machines = read_machines(top, folder, path);
  if (auto tables = top.table("tables")) {
    plan.controllers = tables->texts("controllers");
    tables->finish();
  }
  std::set<std::string> programs, pieces;
  for (TomlReader& entry : top.tables("program")) {
    BatchProgram program{.name = unique_name(entry, programs)};
    program.file = beside(folder, entry.required_text("file"));
    if (const auto job = entry.text("job")) program.job = beside(folder, *job);
    entry.finish();
    plan.programs.push_back(std::move(program));
  }
  for (TomlReader& entry : top.tables("piece")) {
    BatchPiece piece{.name = unique_name(entry, pieces)};
    piece.file = beside(folder, entry.required_text("file"));
    piece.draws = static_cast<int>(whole_number(entry, "draws", kMostDraws, 0));
    piece.first_order = entry.truth("first_order").value_or(false);
    piece.corrected = entry.truth("corrected").value_or(false);
    piece.controllers = entry.texts("tables");
    entry.finish();
    plan.pieces.push_back(std::move(piece));
  }
  top.finish();
  return plan;
}

}  // namespace trunnion
