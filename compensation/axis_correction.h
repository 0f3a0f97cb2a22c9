#pragma once

#include "model/model.h"

namespace trunnion {

/// What a compensation adds to the commands of the five axes.
struct AxisCorrection {
  Eigen::Vector3d linear_mm = Eigen::Vector3d::Zero();  ///< motion of the tool against the workpiece, along R's axes
  double tilt_rad = 0;                                  ///< to the command of A (or B), in its own sense
  double turn_rad = 0;                                  ///< to the command of C, in its own sense

  AxisCorrection& operator+=(const AxisCorrection& other);
};

/// A control that carries a compensation, played: what it adds where it is commanded to be.
class PlayedCompensation {
 public:
  virtual ~PlayedCompensation() = default;
  virtual AxisCorrection at(const Situation& commanded) const = 0;
};

/// What is left between workpiece and tool.
struct Remaining {
  Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();  ///< workpiece point minus tool tip, in R
  double tilt_rad = 0;  ///< angle between the tool's axis on the workpiece and where it should stand
};

/// The machine of `model` commanded to `s` with `correction` added, exact in the correction: rotary axes really turn to
/// A + dA, C + dC and the model is asked there,
///   position = T(e') r_from_w(A', C') w - (p + c + tool side's motion),   w = r_from_w(A, C)^-1 p.
Remaining remaining(const Model& model, const KinematicChain& chain, const Situation& s,
                    const AxisCorrection& correction);

/// The best that five axes can do: position exact, the tool's axis as near as A and C bring it. With u the nominal tool
/// axis on the workpiece and v its image at the corrected angles, A and C minimise
///   |v - v_nominal|^2 + lambda^2 (C' - C)^2,   lambda = sin 1 deg,
/// because near a tilt of zero C can move the axis no more; |C' - C| saturates at `limits.rotary_word`.
AxisCorrection ideal_correction(const Model& model, const KinematicChain& chain, const CorrectionLimits& limits,
                                const Situation& s);

}  // namespace trunnion
