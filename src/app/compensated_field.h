#pragma once

#include <memory>
#include <string>

#include "compensation/axis_correction.h"
#include "postproc/correction.h"

namespace trunnion {

/// What is left of a machine's errors where its control plays a compensation already: commanded to A, C it goes to
/// A + dA, C + dC and shifts the tool by the table's lengths, so that
///   T(Delta) = K^-1 T(e(A', C')) r_from_w(A', C') r_from_w(A, C)^-1,   K the tool's own change of place.
class CompensatedField : public ErrorField {
 public:
  /// `errors`, `chain` must outlive it.
  CompensatedField(const ErrorField& errors, const KinematicChain& chain, std::unique_ptr<PlayedCompensation> played)
      : errors_(errors), chain_(chain), played_(std::move(played)) {}

  PoseError at(const Situation& situation) const override;
  Range<Angle> tilt_range() const override { return errors_.tilt_range(); }

 private:
  const ErrorField& errors_;
  const KinematicChain& chain_;
  std::unique_ptr<PlayedCompensation> played_;
};

}  // namespace trunnion
