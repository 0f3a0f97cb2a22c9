#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "errormap/error_grid.h"

namespace trunnion {

/// The twelve errors as functions of (a, c), continuous and 2 pi-periodic in c, linear in a vector of coefficients:
///   E(a, c) = B(a, c) theta,   B: 12 x m,  rows EXA … ECA, EXC … ECC.
class ErrorSurface {
 public:
  virtual ~ErrorSurface() = default;

  /// The errors at `position`, whatever its turn of C. Throws RangeError for a tilt more than kMargin outside
  /// a_range(): the margin is for a command's own correction, what is asked for is checked by the caller with covers().
  virtual RotaryErrors at(IndexedPosition position) const = 0;
  /// B(a, c), 12 x m. Throws as at().
  virtual Eigen::Matrix<double, 12, Eigen::Dynamic> jacobian(IndexedPosition position) const = 0;
  virtual Eigen::Index coefficient_count() const = 0;
  virtual Range<Angle> a_range() const = 0;

  /// Whether the tilt lies within the probed range, to 1e-9 deg of rounding.
  bool covers(Angle a) const;

  static constexpr Angle kMargin = Angle::degrees(0.5);

 protected:
  void check(Angle a) const;
};

/// What stands between the nodes of a map.
enum class Interpolation { trig_cubic, bilinear, natural_neighbour };

/// "trig-cubic", "bilinear", "natural-neighbour".
std::string_view interpolation_name(Interpolation method);
std::optional<Interpolation> interpolation_from_name(std::string_view name);

/// A surface through the nodes of a grid; its coefficients are those of the grid. Throws ModelError for a grid whose
/// stations do not ascend strictly, whose C stations span a turn or more, or whose values do not match its stations.
///
/// - trig_cubic: trigonometric in C up to floor((n-1)/2), with the cosine at the Nyquist harmonic (phased at the nodes)
/// for
///   even n, times a cubic spline in A: not-a-knot, natural for three stations, a line for two, a constant for one.
/// - bilinear: as controllers do, between neighbouring stations, periodic in C.
/// - natural_neighbour: Sibson's C1 interpolant (CGAL) for C's six, local; the tilting axis' six as for trig_cubic.
/// Beyond the end stations, within kMargin, C's six stay what they are there.
std::unique_ptr<ErrorSurface> make_surface(Interpolation method, const ErrorGrid& grid);

}  // namespace trunnion
