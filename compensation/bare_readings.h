#pragma once

#include "compensation/axis_correction.h"
#include "probing/observation.h"

namespace trunnion {

/// Readings that were taken while `played` was switched on, as the machine itself would have given them. Commanded to
/// p at A, C the machine went to p + c at A + dA, C + dC; a touch there is a touch of the bare machine at those places:
///   contact:      at A', C', contact point p + c
///   displacement: at A', C', n . (d + p + c - p'),  p' = r_from_w(A', C') r_from_w(A, C)^-1 p where the ball then is
///   rotation:     at A', C', less the turn from A, C to A', C' about the sensing axis
///   pose:         at A', C'
/// `set` in inside units. Throws InputError, naming file and line, for the points of a measured piece: how it was cut
/// is for its program to say.
ObservationSet bare_readings(ObservationSet set, const PlayedCompensation& played, const KinematicChain& chain);

/// A model that a control carries, or by which programs are corrected, played as the best that five axes can do.
class PlayedModel : public PlayedCompensation {
 public:
  PlayedModel(Model model, const KinematicChain& chain, const CorrectionLimits& limits)
      : model_(std::move(model)), chain_(chain), limits_(limits) {}
  AxisCorrection at(const Situation& commanded) const override {
    return ideal_correction(model_, chain_, limits_, commanded);
  }

 private:
  Model model_;
  KinematicChain chain_;
  CorrectionLimits limits_;
};

}  // namespace trunnion
