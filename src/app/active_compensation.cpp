#include "app/active_compensation.h"

#include <algorithm>
#include <filesystem>

#include "app/table_folder.h"
#include "compensation/verification.h"
#include "io/model_file.h"

namespace trunnion {

ObservationSet without_active(ObservationSet set, const std::string& path, const Machine& machine,
                              std::vector<std::string>& inputs) {
  const auto add = [&inputs](const std::string& file) {
    if (std::ranges::find(inputs, file) == inputs.end()) inputs.push_back(file);
  };
  if (std::filesystem::is_directory(path)) {
    const std::vector<TableFile> files = files_in(path);
    for (const TableFile& file : files)
      if (!file.name.starts_with("commissioning/")) add((std::filesystem::path(path) / file.name).string());
    return without_active(std::move(set), files, machine);
  }
  add(path);
  return without_active(std::move(set), read_model(path, machine), machine);
}

ObservationSet without_active(ObservationSet set, const Model& model, const Machine& machine) {
  check_same_machine(model, machine, "active");
  const KinematicChain chain(machine);
  return bare_readings(std::move(set), PlayedModel(model, chain, machine.limits), chain);
}

ObservationSet without_active(ObservationSet set, const std::vector<TableFile>& tables, const Machine& machine) {
  const Model none;
  return bare_readings(std::move(set), *play_tables(tables, machine, none), KinematicChain(machine));
}

}  // namespace trunnion
