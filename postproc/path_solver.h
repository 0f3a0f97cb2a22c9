#pragma once

#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "kinematics/machine.h"
#include "postproc/correction.h"
#include "postproc/motion.h"

namespace trunnion {

/// The machine's bounds on what may be corrected.
struct CorrectionGuard {
  CorrectionLimits limits;
  Length change = Length::micrometres(200);   ///< of the position's correction from one block at feed to the next
  Angle rotary_change = Angle::degrees(0.1);  ///< of A's and C's likewise
  std::array<std::optional<std::pair<double, double>>, kAxes> stroke;  ///< mm and deg, lowest and highest
  double tolerance_mm = 0.0002;                                        ///< of the tip between end points
  double tolerance_rad = 2e-6;                                         ///< of the tool axis between end points
  int most_pieces = 1000;                                              ///< of one line
  int most_arc_pieces = 20000;                                         ///< of one arc
};

/// Strokes and limits of a machine file.
CorrectionGuard guard_of(const Machine& machine);

/// A correction in the units of the program, rounded as it is written.
using Ticks = std::array<Decimal, kAxes>;

/// The correction of one place.
struct Solution {
  AxisValues programmed{};
  Commanded commanded;  ///< as written
  Ticks ticks{};
  Angle tilt_by, turn_by;  ///< what the words of the rotary axes are changed by
  Corrector::Linear linear;
  Angle residual;
};

/// The ends of the pieces into which a block is divided.
struct Way {
  std::vector<Solution> ends;
  bool within_tolerance = true;
};

/// Millimetres along X Y Z, and degrees over both rotary axes.
inline double squared(double x) { return x * x; }
inline double length2_mm2(const AxisValues& from, const AxisValues& to) {
  return squared(to[0] - from[0]) + squared(to[1] - from[1]) + squared(to[2] - from[2]);
}
inline double turn2_deg2(const AxisValues& from, const AxisValues& to) {
  return squared(to[kTilt] - from[kTilt]) + squared(to[kTurn] - from[kTurn]);
}
inline double length_mm(const AxisValues& from, const AxisValues& to) { return std::sqrt(length2_mm2(from, to)); }
inline double turn_deg(const AxisValues& from, const AxisValues& to) { return std::sqrt(turn2_deg2(from, to)); }

/// Of R or W, from one of the program's frame, and back.
Eigen::Vector3d out_of_frame(const MotionBlock& block, const Eigen::Vector3d& v);
Eigen::Vector3d into_frame(const MotionBlock& block, const Eigen::Vector3d& v);

/// The correction of blocks as numbers: of one place, and of the way between two, divided until it holds. Nothing here
/// depends on other blocks, nor on how a block is written.
class PathSolver {
 public:
  /// The correctors for blocks with tool-centre-point control and without must outlive it.
  PathSolver(const Corrector& with_tcp, const Corrector& without_tcp, CorrectionGuard guard,
             std::array<char, kAxes> letters)
      : with_tcp_(with_tcp), without_tcp_(without_tcp), guard_(guard), letters_(letters) {}

  const Corrector& corrector(const MotionBlock& block) const { return block.tcp ? with_tcp_ : without_tcp_; }

  /// The correction at a place of the block's way. Throws RangeError where nothing was measured or the model leaps.
  void solve(const MotionBlock& block, const AxisValues& at, Solution& solution) const;
  Solution solved(const MotionBlock& block, const AxisValues& at) const;

  /// Throw RangeError: limits and strokes at one place, and from the block before to this one.
  void check(const AxisValues& at, const Solution& solution) const;
  void check_change(const Solution& before, const Solution& now) const;

  /// Whether the correction of one place differs by more than the tolerance, as it does for another sense of motion.
  bool leaps(const Solution& before, const Solution& now) const;

  /// Moves so short that the correction cannot bend them by more than the tolerance.
  bool is_short(const MotionBlock& block) const;
  /// By how much an arc is moved if it stays an arc within tolerance, in the program's frame: from where it begins
  /// corrected to where it ends corrected, its centre midway. Arcs whose centre the block does not tell stay only
  /// unmoved.
  std::optional<Eigen::Vector3d> moved_arc(const MotionBlock& block, const Ticks& before, const Solution& end) const;
  /// The block's way in as many pieces as it needs; `end`: the solution at its end.
  Way way(const MotionBlock& block, const Solution& end) const;

 private:
  Commanded commanded(const MotionBlock& block, const AxisValues& at) const;
  AxisValues place_between(const MotionBlock& block, const AxisValues& from, const AxisValues& to, double s) const;
  AxisValues on_way(const MotionBlock& block, double s) const;
  Commanded sent_between(const MotionBlock& block, const Commanded& from, const Commanded& to, double s) const;
  bool turns(const MotionBlock& block) const;
  double tilt_left_rad(const MotionBlock& block, const Commanded& wanted, const Commanded& sent) const;
  bool holds_between(const MotionBlock& block, const Solution& from, double from_part, const Solution& to,
                     double to_part, double& tip_mm, double& tilt_rad) const;

  const Corrector& with_tcp_;
  const Corrector& without_tcp_;
  CorrectionGuard guard_;
  std::array<char, kAxes> letters_;
};

}  // namespace trunnion
