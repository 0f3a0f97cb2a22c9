#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <vector>

#include "kinematics/kinematic_chain.h"
#include "testpiece/cone_frustum.h"

namespace trunnion {

/// The tool as the workpiece sees it.
struct ToolInWorkpiece {
  Eigen::Vector3d tip_w_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_w = Eigen::Vector3d::UnitZ();  ///< unit vector from the tip to the spindle
};

/// One commanded position of a path, and what is known of the moment.
struct ToolPosition {
  double phi_rad = 0;  ///< where it is meant to cut, running on over the turns
  ToolInWorkpiece nominal;
  IndexedPosition at;                                      ///< rotary axes as commanded, unwrapped
  Eigen::Vector3d tip_r_mm = Eigen::Vector3d::Zero();      ///< commanded tip in R
  Eigen::Vector3d linear_sense = Eigen::Vector3d::Zero();  ///< senses of the last motions
  int tilt_sense = 1;
  int turn_sense = 1;
  double time_s = 0;
};

/// Tilts from 0 to -180 deg (the branch A <= 0) and the turn of C, within half a turn of `near_c`, that put the tool
/// along `axis_w` of the workpiece. C stays at `near_c` where the tool stands along W's Z. Throws ModelError for a
/// machine whose rotary axes cannot do it.
IndexedPosition rotary_position_along(const KinematicChain& chain, const Eigen::Vector3d& axis_w, Angle near_c);

/// How closely a path's positions follow one another.
struct PathSampling {
  int steps_per_turn = 7200;                 ///< raised to the next multiple of the evaluated points
  Angle largest_turn = Angle::degrees(0.5);  ///< of C between two positions; closer where C runs fast
};

/// The rulings of a flank: where the one at phi meets the base's circle.
using Rulings = std::function<ConePoint(Angle phi)>;
/// Those of the formula, cone_point.
Rulings formula_rulings(const ConeFrustum& cone);

/// Flank milling of the piece, once round from phi = 0: tool axis along the ruling, tip `overhang` below the base,
///   tip = p(phi, 0) + (diameter / 2) normal - overhang ruling,
/// A <= 0, C unwrapped. Where the tool comes to stand along W's Z (tilt = half angle), C swings there with the tip at
/// rest. Senses of motion follow from the commands; the first position is taken to be reached by the motion that
/// follows it. An axis that never moves keeps the sense of every effect's zero.
/// The surface is that of `rulings` (empty: the formula's).
std::vector<ToolPosition> flank_milling_path(const TestPiece& piece, const KinematicChain& chain,
                                             const PathSampling& sampling = {}, Rulings rulings = {});

/// Sets the senses of motion of a path from its commands. A linear axis has turned about once it has come back by more
/// than `rounding`: a program's words, rounded in W, make an axis tremble that is meant to stand still in R.
void set_senses(std::vector<ToolPosition>& path, const KinematicChain& chain, Length tool_length,
                Length rounding = Length::millimetres(1e-10));

/// Sets the times of a path: from 0, by the piece's feed over the nominal tip's way on the workpiece; without a feed
/// time stands still.
void set_times(std::vector<ToolPosition>& path, const TestPiece& piece);

/// The slides' positions X Y Z that bring the tip to `tip_r_mm`.
Eigen::Vector3d slides_mm(const KinematicChain& chain, const Eigen::Vector3d& tip_r_mm, IndexedPosition at,
                          Length tool_length);

}  // namespace trunnion
