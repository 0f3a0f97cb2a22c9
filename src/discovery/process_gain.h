#pragma once

#include <Eigen/Core>

#include "discovery/projection.h"

namespace trunnion {

/// Gain in restricted log likelihood of a process with columns Z (unit prior), over its amplitude a:
///   -1/2 log det(I + a^2 G) + 1/2 b' (I / a^2 + G)^-1 b,   G = Z' P Z, b = Z' P y, noise as declared.
struct ProcessGain {
  double gain = 0;
  double amplitude = 0;         ///< standard deviation of the process, in units of a column
  double explained = 0;         ///< chi-square that it takes away
  double visible_fraction = 0;  ///< ||P Z b|| / ||Z b|| of the process as it is found
};
ProcessGain best_process_gain(const Projection& base, const Eigen::MatrixXd& z);

}  // namespace trunnion
