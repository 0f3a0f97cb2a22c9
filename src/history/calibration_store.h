#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "history/database.h"
#include "model/model.h"

namespace trunnion {

/// A calibration as a history keeps it.
struct Calibration {
  std::int64_t id = 0;  ///< given by the store, in the order of adding
  MachineIdentity machine;
  std::string taken;  ///< when the readings were taken, ISO 8601, UTC: sorts as text
  std::string model_sha256;
  std::string note;
  std::optional<std::string> closure;                       ///< text of closure.json
  std::vector<std::pair<std::string, std::string>> inputs;  ///< name and SHA-256 of what the model was made from
  std::string machine_file, model;                          ///< texts
};

/// Calibrations of any number of machines in a database. Adding is whole or not at all, whatever interrupts it.
class CalibrationStore {
 public:
  /// Makes or migrates the tables where needed. Throws InputError for a database that is not Trunnion's or a later
  /// program's.
  explicit CalibrationStore(std::unique_ptr<Database> database);

  /// The id of a calibration in the store, new or old.
  struct Added {
    std::int64_t id = 0;
    bool stood_already = false;
  };
  /// Adds a calibration, whose id is ignored; one that stands already is left as it is. Throws RefusalError where the
  /// serial number is known with another machine's name or structure, InputError where the same model is known with
  /// another date.
  Added add(const Calibration& calibration);

  /// All calibrations, of one machine if `serial` names it, by serial number, then by date; without the texts of model
  /// and machine file.
  std::vector<Calibration> list(const std::optional<std::string>& serial) const;

  /// Throws InputError for an id that is not there.
  Calibration get(std::int64_t id) const;

  const std::string& name() const { return database_->name(); }

 private:
  std::unique_ptr<Database> database_;
};

}  // namespace trunnion
