#pragma once

#include <map>
#include <string>
#include <string_view>

namespace trunnion {

/// Alarm limits by the name of an error (EX0C, EXA, "linear_scale:X scale"), in the error's own unit (um, urad …).
struct AlarmLimits {
  std::map<std::string, double> value;   ///< largest size
  std::map<std::string, double> change;  ///< largest change since the first calibration
  friend bool operator==(const AlarmLimits&, const AlarmLimits&) = default;
};

/// A limits file (TOML: format = "trunnion-limits", version = 1, tables [value] and [change] of positive numbers).
/// Throws InputError with file and line.
AlarmLimits read_limits(const std::string& path);
/// The same from text; `name` stands for the file in messages.
AlarmLimits parse_limits(std::string_view text, const std::string& name);

}  // namespace trunnion
