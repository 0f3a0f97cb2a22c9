#pragma once

#include <span>

#include "probing/observation.h"
#include "testpiece/measured_piece.h"

namespace trunnion {

/// A measured piece as observations: each point, at the moment when it was cut, reads the machine's error along the
/// inward normal. The situations along the path give position, senses of motion and time; columns `time_s` and
/// `temperature_C` of the measured file go before them, its other columns and the job's are covariates.
struct PieceObservations {
  ObservationSet set;
  std::vector<std::size_t> point_of_row;  ///< index into MeasuredPiece::points
  std::size_t unsteady = 0;               ///< points left out because several moments have part in them
  double sigma_mm = 0;                    ///< root mean square
  bool sigma_told = false;                ///< by the file; else from point to point
};

/// A measured piece, and how it was cut. What is referred to must outlive it.
struct PieceReading {
  const TestPiece& piece;
  const MeasuredPiece& measured;
  std::span<const ToolPosition> path;
  const KinematicChain& chain;
  Situation known;     ///< what the job tells of the moment
  int stretches = 24;  ///< into which the turn is cut
};
/// Throws RangeError where the path never cuts a measured point, InputError where no noise can be told.
PieceObservations observations_of(const PieceReading& reading);

}  // namespace trunnion
