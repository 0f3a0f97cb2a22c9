#include "history/calibration_store.h"

#include <algorithm>
#include <tuple>

#include "error.h"
#include "history/schema.h"

namespace trunnion {
namespace {

constexpr const char* kHead = "id, serial, machine_name, structure, taken, model_sha256, note, closure";

Calibration head_of(const Row& row) {
  const auto text = [&](std::size_t k) { return row[k].value_or(""); };
  return {.id = std::stoll(text(0)),
          .machine = {.name = text(2), .serial = text(1), .structure = text(3)},
          .taken = text(4),
          .model_sha256 = text(5),
          .note = text(6),
          .closure = row[7]};
}

void add_inputs(Database& database, Calibration& calibration) {
  for (const Row& row : database.run("SELECT name, sha256 FROM trunnion_input WHERE calibration = $1 ORDER BY name",
                                     {std::to_string(calibration.id)}))
    calibration.inputs.emplace_back(row[0].value_or(""), row[1].value_or(""));
}

/// What stands under a serial number must be one machine.
void refuse_another_machine(Database& database, const MachineIdentity& machine) {
  for (const Row& row :
       database.run("SELECT machine_name, structure FROM trunnion_calibration WHERE serial = $1", {machine.serial})) {
    if (*row[0] != machine.name)
      throw RefusalError(database.name() + ": serial number \"" + machine.serial + "\" is known here as \"" + *row[0] +
                         "\", the model is of \"" + machine.name + "\"");
    if (*row[1] != machine.structure)
      throw RefusalError(database.name() + ": serial number \"" + machine.serial +
                         "\" is known here with structure \"" + *row[1] + "\", the model's is \"" + machine.structure +
                         "\"");
  }
}

}  // namespace

CalibrationStore::CalibrationStore(std::unique_ptr<Database> database) : database_(std::move(database)) {
  migrate(*database_);
}

CalibrationStore::Added CalibrationStore::add(const Calibration& c) {
  Transaction transaction(*database_);
  refuse_another_machine(*database_, c.machine);
  const std::vector<Row> same =
      database_->run("SELECT id, taken FROM trunnion_calibration WHERE serial = $1 AND model_sha256 = $2",
                     {c.machine.serial, c.model_sha256});
  if (!same.empty()) {
    if (*same[0][1] != c.taken)
      throw InputError(database_->name(), "this model stands here already as calibration " + *same[0][0] + " of " +
                                              *same[0][1] + ", not of " + c.taken);
    return {std::stoll(*same[0][0]), true};
  }
  const std::string id = *database_->run("SELECT COALESCE(MAX(id), 0) + 1 FROM trunnion_calibration")[0][0];
  database_->run(
      "INSERT INTO trunnion_calibration (id, serial, machine_name, structure, taken, machine_file, model, "
      "model_sha256, closure, note) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10)",
      {id, c.machine.serial, c.machine.name, c.machine.structure, c.taken, c.machine_file, c.model, c.model_sha256,
       c.closure, c.note});
  for (const auto& [name, sha256] : c.inputs)
    database_->run("INSERT INTO trunnion_input (calibration, name, sha256) VALUES ($1, $2, $3)", {id, name, sha256});
  transaction.commit();
  return {std::stoll(id), false};
}

std::vector<Calibration> CalibrationStore::list(const std::optional<std::string>& serial) const {
  std::string statement = std::string("SELECT ") + kHead + " FROM trunnion_calibration";
  std::vector<Cell> values;
  if (serial) statement += " WHERE serial = $1", values.emplace_back(*serial);
  std::vector<Calibration> all;
  for (const Row& row : database_->run(statement, values)) {
    all.push_back(head_of(row));
    add_inputs(*database_, all.back());
  }
  // Here and not by the database, whose order depends on its locale.
  std::ranges::sort(all, {}, [](const Calibration& c) { return std::tie(c.machine.serial, c.taken, c.model_sha256); });
  return all;
}

Calibration CalibrationStore::get(std::int64_t id) const {
  const std::vector<Row> rows =
      database_->run(std::string("SELECT ") + kHead + ", machine_file, model FROM trunnion_calibration WHERE id = $1",
                     {std::to_string(id)});
  if (rows.empty())
    throw InputError(database_->name(), "holds no calibration " + std::to_string(id) +
                                            "; trunnion history list shows "
                                            "what it holds");
  Calibration calibration = head_of(rows[0]);
  calibration.machine_file = *rows[0][8];
  calibration.model = *rows[0][9];
  add_inputs(*database_, calibration);
  return calibration;
}

}  // namespace trunnion
