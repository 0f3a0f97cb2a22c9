#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "kinematics/machine.h"
#include "probing/observation.h"

namespace trunnion {

/// An observations file (CSV, CONTRACT: Observations) of `machine`, whose tilting axis names A_deg or B_deg and A_dir
/// or B_dir. Strict: throws InputError with file, line and column, what was found and what is wanted. A numeric column
/// that is not known becomes a covariate.
ObservationSet read_observations(const std::string& path, const Machine& machine);
/// The same from text; `name` stands for the file in messages. `progress` is told the lines read so far, now and then.
using ReadingProgress = std::function<void(std::size_t lines)>;
constexpr std::size_t kLinesBetweenProgress = 4096;
ObservationSet parse_observations(std::string_view text, const std::string& name, const Machine& machine,
                                  const ReadingProgress& progress = {});

/// Contacts as an observations file (CSV): the columns that `set` carries.
std::string observations_text(const ObservationSet& set, char tilt_letter);

}  // namespace trunnion
