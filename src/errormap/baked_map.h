#pragma once

#include <functional>
#include <span>
#include <vector>

#include "geometric_errors/pose_error.h"
#include "kinematics/indexed_position.h"
#include "kinematics/machine.h"

namespace trunnion {

/// How closely a BakedMap shall follow its original.
struct BakeTolerance {
  Length displacement = Length::micrometres(0.001);  ///< of a point at `lever` from R's origin
  Length lever = Length::millimetres(200);
  Angle rotation = Angle::microradians(0.005);
};

/// The largest differences from the original that were found on a grid three times denser each way, borders of the
/// cells included: of the displacement at the tolerance's lever (|D| + lever |theta|), and of the rotation.
struct BakeError {
  Length displacement;
  Angle rotation;
  friend bool operator==(const BakeError&, const BakeError&) = default;
};

/// A pose error and its slopes by the two rotary axes (mm and rad, per rad).
struct PoseErrorSlopes {
  PoseError error;
  PoseError by_a;
  PoseError by_c;
};

/// Six functions of (a, c), sampled on a regular grid, periodic in c, and interpolated by bicubic Hermite pieces:
///
///   E = sum_{i,j in {0,1}} sum_{p,q in {0,1}} h_ip(u) h_jq(v) (d/du)^p (d/dv)^q E[node i, j],
///
/// with slopes at the nodes from differences of fourth order, so that values and slopes are continuous (also over
/// c = 0/360 deg) and a smooth original is met to the fourth order of the spacing. The spacing is halved until the
/// tolerance is met or the grid has kMaxNodes; what was reached is measured and told by error().
class BakedMap {
 public:
  using Original = std::function<PoseError(IndexedPosition)>;

  /// Calls `original` at tilts of `a_range` only, whose ends may coincide.
  BakedMap(const Original& original, Range<Angle> a_range, const BakeTolerance& tolerance = {});

  /// Whatever the turn of C. Throws RangeError for a tilt outside a_range() by more than 1e-9 deg, or no number.
  PoseError at(IndexedPosition position) const;
  PoseErrorSlopes with_slopes(IndexedPosition position) const;

  /// Deviations d = T(e) p - p (mm) at many positions: tilt and turn in rad, points of R in mm. The sines of e are
  /// taken to the second order, which is 1e-10 mm away for angles of a milliradian. Spans of one length; throws as
  /// at().
  void deviations_mm(std::span<const double> a_rad, std::span<const double> c_rad,
                     std::span<const Eigen::Vector3d> points_r_mm, std::span<Eigen::Vector3d> deviations) const;

  Range<Angle> a_range() const { return a_range_; }
  const BakeError& error() const { return error_; }
  bool meets(const BakeTolerance& tolerance) const {
    return error_.displacement <= tolerance.displacement && error_.rotation <= tolerance.rotation;
  }
  std::size_t a_nodes() const { return a_nodes_; }
  std::size_t c_nodes() const { return c_nodes_; }

  static constexpr std::size_t kMaxNodes = std::size_t{1} << 18;

 private:
  struct Place {
    std::size_t i, j, j_next;
    double u, v;
  };
  void bake(const Original& original);
  Place place(double a_rad, double c_rad) const;
  Vector6d value(const Place& place) const;

  Range<Angle> a_range_;
  std::size_t a_nodes_ = 0, c_nodes_ = 0;
  double a_low_ = 0, cells_per_rad_a_ = 0;
  /// Per node E, dE/du, dE/dv, d2E/dudv, six numbers each; rows of equal tilt.
  std::vector<double> nodes_;
  BakeError error_;
};

}  // namespace trunnion
