#include "errormap/pose_split.h"

#include <Eigen/LU>

namespace trunnion {
namespace {

Matrix6d pose_from_tilt(const KinematicChain& chain, IndexedPosition at) {
  return relative_error_jacobian(chain, at, {}).here.leftCols<6>();
}

}  // namespace

Matrix6d turn_from_pose(const KinematicChain& chain, IndexedPosition at) {
  return Matrix6d(relative_error_jacobian(chain, at, {}).here.rightCols<6>()).inverse();
}

PoseSplit split_pose_errors(const KinematicChain& chain, const std::vector<std::vector<SplitNode>>& rows) {
  Eigen::Index nodes = 0;
  for (const std::vector<SplitNode>& row : rows) nodes += static_cast<Eigen::Index>(row.size());
  PoseSplit split{.tilt = Eigen::MatrixXd::Zero(6 * static_cast<Eigen::Index>(rows.size()), 6 * nodes),
                  .turn = Eigen::MatrixXd::Zero(6 * nodes, 6 * nodes)};
  Eigen::Index first = 0, tilt = 0;
  for (const std::vector<SplitNode>& row : rows) {
    Matrix6d carried = Matrix6d::Zero();
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(6, 6 * nodes);
    Eigen::Index node = first;
    for (const SplitNode& at : row) {
      if (at.in_mean) {
        const Matrix6d from_pose = turn_from_pose(chain, at.at);
        carried += from_pose * pose_from_tilt(chain, at.at);
        sum.middleCols<6>(6 * node) = from_pose;
      }
      ++node;
    }
    const bool told = !carried.isZero(0);
    if (told) split.tilt.middleRows<6>(6 * tilt) = carried.inverse() * sum;
    split.told.push_back(told);
    node = first;
    for (const SplitNode& at : row) {
      const Matrix6d from_pose = turn_from_pose(chain, at.at);
      split.turn.middleRows<6>(6 * node) =
          -from_pose * pose_from_tilt(chain, at.at) * split.tilt.middleRows<6>(6 * tilt);
      split.turn.block<6, 6>(6 * node, 6 * node) += from_pose;
      ++node;
    }
    first = node;
    ++tilt;
  }
  return split;
}

}  // namespace trunnion
