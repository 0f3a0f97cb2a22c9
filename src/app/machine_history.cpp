#include "app/machine_history.h"

#include <nlohmann/json.hpp>
#include <set>

#include "error.h"
#include "history/date.h"
#include "io/machine_file.h"
#include "io/model_file.h"
#include "io/sha256.h"

namespace trunnion {
namespace {

/// Why a calibration is no independent look at the machine; empty if it is one.
std::string dependence(const Calibration& c, const Model& model, std::set<std::string>& seen) {
  if (model.fit && model.fit->is_object() && model.fit->contains("prior"))
    return "was identified with an earlier model as its prior";
  std::vector<std::string> data;
  const std::string machine_file = sha256_hex(c.machine_file);
  for (const auto& [name, digits] : c.inputs)
    if (digits != machine_file) data.push_back(digits);
  for (const std::string& digits : data)
    if (seen.contains(digits)) return "was made from readings of another calibration that is compared";
  seen.insert(data.begin(), data.end());
  return "";
}

}  // namespace

Calibration intact(const CalibrationStore& store, std::int64_t id) {
  Calibration calibration = store.get(id);
  if (sha256_hex(calibration.model) != calibration.model_sha256)
    throw InputError(store.name(), "calibration " + std::to_string(id) + " is damaged: its model has another hash");
  return calibration;
}

MachineHistory machine_history(std::vector<Calibration> calibrations) {
  MachineHistory h;
  std::set<std::string> seen;
  for (Calibration& c : calibrations) {
    h.machine = parse_machine(c.machine_file, "calibration " + std::to_string(c.id) + ", machine file");
    Model model = parse_model(c.model, "calibration " + std::to_string(c.id), h.machine);
    if (const std::string why = dependence(c, model, seen); !why.empty()) {
      h.notes.push_back("calibration " + std::to_string(c.id) + " " + why + ": left out");
      continue;
    }
    h.years.push_back(days_of(c.taken) / kDaysPerYear);
    h.models.push_back({h.years.back(), std::move(model)});
    h.calibrations.push_back(std::move(c));
  }
  h.series = error_series(h.models, h.machine);
  for (const std::size_t k : h.series.left_out)
    h.notes.push_back("calibration " + std::to_string(h.calibrations[k].id) +
                      " has no map with standard uncertainties: left out");
  return h;
}

std::vector<Calibration> calibrations_of(const CalibrationStore& store, const std::string& serial) {
  const std::vector<Calibration> heads = store.list(serial.empty() ? std::nullopt : std::optional(serial));
  std::set<std::string> serials;
  for (const Calibration& c : heads) serials.insert(c.machine.serial);
  if (serials.empty())
    throw InputError(store.name(), serial.empty() ? "holds no calibration"
                                                  : "holds no calibration of serial number \"" + serial + "\"");
  if (serials.size() > 1)
    throw UsageError("--serial: the store holds " + std::to_string(serials.size()) +
                     " machines (first: " + *serials.begin() + "); one of them is wanted");
  std::vector<Calibration> all;
  for (const Calibration& c : heads) all.push_back(intact(store, c.id));
  return all;
}

}  // namespace trunnion
