#pragma once

#include "errormap/error_surface.h"

namespace trunnion {

/// A finite basis for the twelve errors: Legendre polynomials P_0 … P_tilt_degree of the tilt, scaled to `a_range`, for
/// the tilting axis; for C the products of cos(hc), sin(hc), h = 1 … harmonics, with P_0 … P_turn_degree. (A mean of
/// C's errors over a turn is the tilting axis' share, Eq. 1, and has no column.)
struct HarmonicBasis {
  Range<Angle> a_range;
  int tilt_degree = 4;
  int harmonics = 2;
  int turn_degree = 2;

  Eigen::Index tilt_functions() const { return tilt_degree + 1; }
  Eigen::Index turn_functions() const { return 2 * harmonics * (turn_degree + 1); }
  Eigen::Index coefficient_count() const { return 6 * (tilt_functions() + turn_functions()); }
  /// Values of the tilt functions, then of the turn functions, ordered by harmonic, cos before sin, then degree.
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
