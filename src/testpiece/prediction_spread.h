#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "testpiece/machining.h"

namespace trunnion {

/// How far a predicted number may be off: its standard deviation and the central 95 % of the draws.
struct DrawnSpread {
  double sd = 0;
  double low = 0;
  double high = 0;
};

/// Of the circle of one height.
struct HeightSpread {
  DrawnSpread lsc_mm, mzc_mm, mic_mm, mcc_mm, diameter_mm, center_x_mm, center_y_mm;
};

/// How far a prediction may be off, all in all.
struct PredictionSpread {
  std::vector<double> deviation_sd_mm;  ///< one per evaluated point, linear
  std::vector<HeightSpread> heights;    ///< by Monte Carlo: roundness is not linear
  std::optional<DrawnSpread> half_angle_rad;
  std::optional<DrawnSpread> axis_tilt_rad;  ///< its amount
  DrawnSpread form_mm;
  DrawnSpread rms_mm;
};

/// The Monte Carlo draws of a prediction.
struct DrawOptions {
  int draws = 2000;
  std::uint64_t seed = 1;
  unsigned threads = 0;                  ///< 0: all processors; the result does not depend on it
  std::function<void(double)> progress;  ///< called with the share done, by one thread at a time
  EvaluationOptions evaluation;
};

/// The deviations' dependence on everything of the model that has a covariance, one column per standard normal
/// variable:
///   deviation = predicted + G z,   G = -n^T [I, -[p]x] B(situation) L,   L L^T the covariance of an effect's
///   parameters,
/// taken at the position that is meant to cut each point. What the map's interpolation may be wrong by between its
/// nodes is no parameter: it comes as a random harmonic of C that the nodes cannot see.
class DeviationSpread {
 public:
  DeviationSpread(const TestPiece& piece, const SurfaceGrid& surface, std::span<const ToolPosition> path,
                  const KinematicChain& chain, const Model& model, const Situation& known = {});

  /// Whether anything is known to vary.
  bool empty() const { return columns_.cols() == 0 && unseen_.empty(); }
  std::vector<double> deviation_sd_mm() const;
  /// What `deviation_mm`, however predicted, spreads to. Draw k depends on the seed and k alone.
  PredictionSpread around(std::span<const double> deviation_mm, const DrawOptions& options = {}) const;

 private:
  TestPiece piece_;
  SurfaceGrid surface_;
  Eigen::MatrixXd columns_;              ///< points x variables
  std::vector<Eigen::MatrixXd> unseen_;  ///< per unseen harmonic of C, points x 12: cosine and sine of the six errors
};

}  // namespace trunnion
