#pragma once

#include "errormap/error_surface.h"

namespace trunnion {

/// A finite basis for the twelve errors. The tilting axis: Legendre polynomials P_0 … P_tilt_degree of the tilt, scaled
/// to `a_range`. C: a constant (its mean place, as a location error of C has it), and for h = 1 … harmonics the
/// products of cos(h c), sin(h c) with the first turn_degree + 1 of {1, sin a, 1 - cos a, sin 2a, 1 - cos 2a}: an error
/// that stands still in the slide or in the table is seen by the other through the tilt, and the first three are what
/// the tilt makes of it.
struct HarmonicBasis {
  Range<Angle> a_range;
  int tilt_degree = 4;
  int harmonics = 2;
  int turn_degree = 2;  ///< 0 to 4

  Eigen::Index tilt_functions() const { return tilt_degree + 1; }
  Eigen::Index turn_functions() const { return 1 + 2 * harmonics * (turn_degree + 1); }
  Eigen::Index coefficient_count() const { return 6 * (tilt_functions() + turn_functions()); }
  /// Values of the tilt functions by degree; of the turn functions: the constant, then by harmonic, cos before sin,
  /// then by function of the tilt.
  Eigen::VectorXd tilt_values(Angle a) const;
  Eigen::VectorXd turn_values(IndexedPosition position) const;
  friend bool operator==(const HarmonicBasis&, const HarmonicBasis&) = default;
};

/// The twelve errors in a HarmonicBasis. Coefficients: six per function (EX… to EC…), tilt functions first.
class HarmonicSurface : public ErrorSurface {
 public:
  /// Throws ModelError unless `coefficients` has 6 per function of `basis`.
  HarmonicSurface(HarmonicBasis basis, Eigen::VectorXd coefficients);

  RotaryErrors at(IndexedPosition position) const override;
  Eigen::Matrix<double, 12, Eigen::Dynamic> jacobian(IndexedPosition position) const override;
  Eigen::Index coefficient_count() const override { return coefficients_.size(); }
  Range<Angle> a_range() const override { return basis_.a_range; }

  const HarmonicBasis& basis() const { return basis_; }
  const Eigen::VectorXd& coefficients() const { return coefficients_; }

 private:
  HarmonicBasis basis_;
  Eigen::VectorXd coefficients_;
};

}  // namespace trunnion
