#pragma once

#include <string>
#include <vector>

#include "history/calibration_store.h"
#include "history/error_series.h"

namespace trunnion {

inline constexpr double kDaysPerYear = 365.25;

/// The calibrations of one machine that are compared: texts, dates and models of the same index.
struct MachineHistory {
  Machine machine;  ///< as of the last one
  std::vector<Calibration> calibrations;
  std::vector<DatedModel> models;
  std::vector<double> years;       ///< of the models
  std::vector<std::string> notes;  ///< which calibrations were left out, and why
  SeriesSet series;
};

/// A calibration's texts, checked against the hash that was stored with them. Throws InputError for a damaged one.
Calibration intact(const CalibrationStore& store, std::int64_t id);

/// All calibrations of the machine `serial`, or of the only one where that is empty. Throws InputError where there is
/// none, UsageError where there are several machines.
std::vector<Calibration> calibrations_of(const CalibrationStore& store, const std::string& serial);

/// Left out are calibrations that are no independent look at the machine: identified with an earlier model as prior, or
/// made from the readings of another one.
MachineHistory machine_history(std::vector<Calibration> calibrations);

}  // namespace trunnion
