#pragma once

#include <array>

#include "compensation/controller.h"
#include "compensation/piecewise_linear.h"

namespace trunnion {

/// How much a pose error of the table matters over the working volume: the mean square of the deviation it makes, plus
/// the tilt of the tool seen 20 mm along its axis, as a quadratic form of its twist t = (D, theta) at R's origin,
///   t^T W t = E |D + theta x p|^2 + (20 mm)^2 |theta across the tool|^2.
/// p spread evenly over the volume: with its centre m and variances v,
///   E |D + theta x p|^2 = |D + theta x m|^2 + sum_k v_k |theta x e_k|^2.
Matrix6d volume_metric(const WorkingVolume& volume);

/// Alike where X, Y, Z put the position right by themselves: the tilt of the tool alone, and so that a turn of C is
/// told where the table is level, its rotation about the tool by (20 mm x sin 5 deg)^2.
Matrix6d orientation_metric();

/// The effects of the machine that do not ask where the linear axes stand, at a tip in the middle of the volume.
PoseError rotary_part(const CompensationTask& task, IndexedPosition at, int tilt_sense = 1, int turn_sense = 1);

/// What the effects that depend on one linear axis add at its coordinate: a twist of the table at R's origin, and a
/// deviation of the tip alone.
struct LinearPart {
  char axis = 'X';
  std::vector<double> stations_mm;
  std::vector<Vector6d> table;       ///< twist at R's origin
  std::vector<Eigen::Vector3d> tip;  ///< deviation that does not come from a twist of the table, mm
};
/// One for each linear axis that matters, sampled every `step_mm` over its stroke in the working volume widened to
/// what the machine file gives. An effect of two or more linear axes is taken along each from the volume's middle.
std::vector<LinearPart> linear_parts(const CompensationTask& task, double step_mm);

/// How far a rotary joint that last moved negatively stands from where it stands after a positive motion, in its own
/// sense, averaged over the volume: what the model's reversal effects come to on that joint alone.
double reversal_rad(const CompensationTask& task, char axis);

/// Corrections of A and C by functions of their own position alone, nearest to the model in the metric given:
/// f(A) and g(C), add to command, at the given positions.
struct OwnAxisFit {
  std::vector<double> tilt_rad;
  std::vector<double> turn_rad;
  Eigen::VectorXd constants;  ///< how far the axes stand from where the control believes, where it can be told
};
/// With `constants`, an effect of parameters that the control can be told, its lengths are fitted alongside and its
/// angles left zero.
OwnAxisFit own_axis_fit(const CompensationTask& task, const Matrix6d& metric, const std::vector<double>& tilt_at_deg,
                        const std::vector<double>& turn_at_deg, const EffectPtr& constants = nullptr);

/// What five axes add where each may do anything over (A, C), and the linear ones besides move in proportion to their
/// own places by functions of A and of C: the best of a format with tables over pairs of axes. Rows run over A, columns
/// over C.
struct PairFit {
  Eigen::MatrixXd tilt_rad, turn_rad;
  std::array<Eigen::MatrixXd, 3> shift_mm;  ///< of X, Y, Z at R's origin
  /// mm per mm, one per A and one per C (these of mean zero), to be added: column k goes with coordinate k.
  std::vector<Eigen::Matrix3d> tilt_lever, turn_lever;
  /// What is left of the turning, A outer: mm that it spreads along each axis (3 x 3), and the tilt seen at 20 mm.
  Eigen::Matrix<double, 11, Eigen::Dynamic> left;
};
/// Least squares in the volume's metric at the given positions. With `followed`, an effect of the table, X Y Z follow
/// the displacement that it makes already, and nobody has followed its tilt.
PairFit pair_fit(const CompensationTask& task, const std::vector<double>& tilt_at_deg,
                 const std::vector<double>& turn_at_deg, const EffectPtr& followed = nullptr);

/// The location errors that X, Y, Z shall follow by the control's own transformation, so that what pair_fit leaves
/// beside them is least; among equals, those that leave its tables least to do.
EffectPtr followed_location(const CompensationTask& task);

/// The table's error as an error of A that depends on A and one of C that depends on C, each in its axis' frame before
/// its motion, nearest in the volume's metric: e(A, C) = Ad_A eA(A) + Ad_C(A) eC(C), Ad_A for where A's line stands.
/// With `turn_by_both` eC may depend on A too and nothing is left out; then eA is the mean over C. One column per A;
/// per A and C, A outer.
struct ChainFit {
  Matrix6Xd tilt;
  Matrix6Xd turn;
};
/// Whether the errors of C may depend on C alone, or on A as well.
enum class TurnErrors { of_turn_alone, of_both };
ChainFit chain_fit(const CompensationTask& task, const std::vector<double>& tilt_at_deg,
                   const std::vector<double>& turn_at_deg, TurnErrors turn_errors);

}  // namespace trunnion
