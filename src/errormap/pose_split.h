#pragma once

#include <Eigen/Core>
#include <vector>

#include "geometric_errors/rotary_errors.h"

namespace trunnion {

/// A pose at which a table's error is known.
struct SplitNode {
  IndexedPosition at;
  bool in_mean = true;  ///< whether it takes part in the mean of Eq. (1)
};

/// The errors of the two rotary axes, told apart from the table's pose errors by C's averaging to zero over the nodes
/// of each tilt (Eq. 1, 12 and 13), to first order, for a tilting axis that carries C:
///   E_tilt(a) = (sum_j T_j^-1 U_j)^-1 sum_j T_j^-1 Delta_j,   E_C(a, c_j) = T_j^-1 (Delta_j - U_j E_tilt(a)),
/// U and T being the derivatives of Delta by the two axes' errors. Linear, so it is kept as two matrices over the
/// stacked pose errors (Dx … Dc of each node in turn; mm, rad).
struct PoseSplit {
  Eigen::MatrixXd tilt;    ///< 6 rows a tilt
  Eigen::MatrixXd turn;    ///< 6 rows a node
  std::vector<bool> told;  ///< one a tilt: whether any node of it is in the mean; else its rows are zero
};

/// `rows` are the nodes by tilt; nodes of one row share their tilt.
PoseSplit split_pose_errors(const KinematicChain& chain, const std::vector<std::vector<SplitNode>>& rows);

/// The part of C's errors that a pose error at `at` is, were they alone wrong: T^-1, 6 x 6.
Matrix6d turn_from_pose(const KinematicChain& chain, IndexedPosition at);

}  // namespace trunnion
