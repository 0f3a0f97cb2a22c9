#pragma once

#include <optional>
#include <span>
#include <string>

#include "io/prediction_file.h"

namespace trunnion {

/// Roundness, centre and size by height of every way in which the piece was cut (and of the measured piece, if there is
/// one), size, angle and axis, and what each compensation takes away, for people.
std::string prediction_text(const TestPiece& piece, std::span<const PredictedPiece> pieces,
                            const std::optional<ConeEvaluation>& measured);

}  // namespace trunnion
