#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "postproc/playback.h"

namespace trunnion {

/// What `correct --json` and `--report` tell of a corrected program: how it was read, what was changed, what was
/// refused, and, played back, how far the tool was off before and is after. `nc_program` is the program's name without
/// folders. Lengths um, angles urad, those of C deg.
nlohmann::json correction_json(const std::string& nc_program, bool orientation, const ProgramCorrection& how,
                               const ProgramCorrectionResult& result, const std::optional<PlaybackResult>& played);

/// What was taken for granted of the control and not confirmed, where the program makes use of it: a sentence each.
std::vector<std::string> assumptions_met(const CorrectionCounts& counts);

/// How much of each limit the written program uses, for people.
std::string limits_text(const PlaybackResult& played);

/// The summary for people.
std::string correction_text(const ProgramCorrectionResult& result, const std::optional<PlaybackResult>& played);

}  // namespace trunnion
