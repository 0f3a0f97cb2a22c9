#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "discovery/closure.h"
#include "io/piece_observations.h"
#include "kinematics/machine.h"

namespace trunnion {

/// Files of a piece that was cut and measured.
struct PieceFiles {
  std::string piece, measured, program, job;
};

/// A measured piece in the search for missing effects: its points as readings, and what the search made of them.
class PieceClosure {
 public:
  /// Reads the files and finds the moment at which each point was cut: by the program, or the planned path. Adds what
  /// was read to `inputs`. Throws InputError, RangeError.
  PieceClosure(const PieceFiles& files, const Machine& machine, std::vector<std::string>& inputs);

  const PieceObservations& observations() const { return observations_; }

  /// `piece` of closure.json: what is left of the difference between measured and predicted, set-up and size taken out,
  /// before and after; `first_row` is that of the piece's first reading.
  nlohmann::json json(const ClosureResult& result, std::size_t first_row) const;
  /// phi_deg,h_mm,measured_um,predicted_before_um,predicted_after_um (CSV), the predictions as set up on the measuring
  /// machine.
  std::string csv(const ClosureResult& result, std::size_t first_row) const;

 private:
  nlohmann::json left(const ClosureResult& result, const std::vector<double>& residual, std::size_t first_row) const;

  TestPiece piece_;
  MeasuredPiece measured_;
  PieceObservations observations_;
};

}  // namespace trunnion
