#include "history/schema.h"

#include "error.h"

namespace trunnion {
namespace {

const std::string kVersionTable = "trunnion_schema";

void refuse_later(const Database& database, int version) {
  if (version > static_cast<int>(migrations().size()))
    throw InputError(database.name(), "is of version " + std::to_string(version) + ", this program knows " +
                                          std::to_string(migrations().size()) + "; a later trunnion wrote it");
}

}  // namespace

const std::vector<std::vector<std::string>>& migrations() {
  // A version that has been in use is never edited: what changes is added as the next one.
  static const std::vector<std::vector<std::string>> all = {
      {
          "CREATE TABLE trunnion_schema (version INTEGER NOT NULL)",
          "INSERT INTO trunnion_schema VALUES (0)",
          "CREATE TABLE trunnion_calibration (id BIGINT PRIMARY KEY, serial TEXT NOT NULL, machine_name TEXT NOT NULL, "
          "structure TEXT NOT NULL, taken TEXT NOT NULL, machine_file TEXT NOT NULL, model TEXT NOT NULL, "
          "model_sha256 TEXT NOT NULL, UNIQUE (serial, model_sha256))",
          "CREATE TABLE trunnion_input (calibration BIGINT NOT NULL REFERENCES trunnion_calibration (id), "
          "name TEXT NOT NULL, sha256 TEXT NOT NULL, PRIMARY KEY (calibration, name))",
      },
      {
          "ALTER TABLE trunnion_calibration ADD COLUMN closure TEXT",
          "ALTER TABLE trunnion_calibration ADD COLUMN note TEXT NOT NULL DEFAULT ''",
          "CREATE INDEX trunnion_calibration_in_time ON trunnion_calibration (serial, taken)",
      },
  };
  return all;
}

int schema_version(Database& database) {
  if (!database.has_table(kVersionTable)) return 0;
  const std::vector<Row> rows = database.run("SELECT version FROM trunnion_schema");
  if (rows.size() != 1 || !rows[0][0]) throw InputError(database.name(), "is damaged: its version cannot be read");
  return std::stoi(*rows[0][0]);
}

void migrate(Database& database) {
  const int last = static_cast<int>(migrations().size());
  const int found = schema_version(database);
  refuse_later(database, found);
  if (found == last) return;
  Transaction transaction(database);
  const int version = schema_version(database);  // another process may have been faster
  refuse_later(database, version);
  for (int k = version; k < last; ++k)
    for (const std::string& statement : migrations()[static_cast<std::size_t>(k)]) database.run(statement);
  database.run("UPDATE trunnion_schema SET version = $1", {std::to_string(last)});
  transaction.commit();
}

}  // namespace trunnion
