#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "app/machine_history.h"
#include "history/alarm.h"
#include "history/change.h"

namespace trunnion {

/// A p below which a single comparison is called a difference, and the false alarms of one run of drift over all
/// errors.
inline constexpr double kTold = 0.01;

/// Everything of a calibration but its texts.
nlohmann::json calibration_json(const Calibration& calibration);
std::string calibration_table(const std::vector<Calibration>& calibrations);
std::string calibration_text(const Calibration& calibration);

/// Each error in the first and the last calibration and what it changed by, functions where the last is largest.
std::string trend_text(const MachineHistory& history);
/// One row an error, calibration and position: value, std and 95 % band.
std::string trend_csv(const MachineHistory& history);
nlohmann::json alarm_json(const Alarm& alarm, char tilt_letter);
std::string alarm_text(const Alarm& alarm, char tilt_letter);

/// Every error of the two calibrations of `history`.
std::string comparison_text(const MachineHistory& history);
nlohmann::json comparison_json(const MachineHistory& history);

/// `course` of the pose errors, `parameters` of the machine's other effects, in the order of the series.
std::string drift_text(const MachineHistory& history, const CourseFinding& course,
                       const std::vector<CourseFinding>& parameters);
nlohmann::json drift_json(const MachineHistory& history, const CourseFinding& course,
                          const std::vector<CourseFinding>& parameters);

}  // namespace trunnion
