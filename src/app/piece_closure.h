#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "discovery/closure.h"
#include "io/job_file.h"
#include "io/piece_observations.h"
#include "kinematics/machine.h"

namespace trunnion {

/// Files of a piece that was cut and measured.
struct PieceFiles {
  std::string piece, measured, program, job;
};

/// A piece that was cut and measured, as its files tell it.
struct CutPiece {
  TestPiece piece;
  MeasuredPiece measured;
  Job job;                                               ///< work offsets and covariates of the cut
  std::string program;                                   ///< that cut it; empty: the planned path
  std::string name = "piece", program_name = "program";  ///< for messages
};

/// Reads the files and adds them to `inputs`. Throws InputError.
CutPiece read_cut_piece(const PieceFiles& files, std::vector<std::string>& inputs);

/// A measured piece in the search for missing effects: its points as readings, and what the search made of them.
class PieceClosure {
 public:
  /// Finds the moment at which each point was cut: by the program, or the planned path. Throws InputError, RangeError,
  /// and RefusalError for a program that was corrected for another serial number.
  PieceClosure(CutPiece cut, const Machine& machine);

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
