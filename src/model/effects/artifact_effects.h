#pragma once

#include "model/catalogue.h"

namespace trunnion {

/// Every body at once, in place of a label.
inline constexpr std::string_view kAllArtifacts = "all";

/// Whether a reading is taken of the body.
inline bool concerns(const Situation& s, std::string_view label) {
  return s.reading != ReadingKind::none && (label == kAllArtifacts || s.artifact == label);
}

/// Columns `factor` x a step of the touched body along W's X, Y, Z, as seen in R: 6 x 3.
inline Matrix6Xd steps_in_w(const KinematicChain& chain, const Situation& s, double factor) {
  Matrix6Xd b = Matrix6Xd::Zero(6, 3);
  if (factor != 0) b.topRows<3>() = factor * chain.r_from_w(s.at).linear();
  return b;
}

}  // namespace trunnion
