#pragma once

#include <Eigen/Core>

#include "compensation/projection.h"

namespace trunnion {

/// Tables that move nothing where the machine is set up and where they are switched on. A function of A, of C or of
/// both is given by its samples; its table is the nearest piecewise linear function, and of those that have a given
/// value at A = C = 0 the nearest is (PiecewiseLinear::yielding)
///   f + (value - f(0, 0)) y_A y_C.
/// What is returned are samples again, whose table has the value. Where the working volume does not reach A = 0 nothing
/// is asked of a table, and samples come back as they were.
class AtReference {
 public:
  AtReference(const WorkingVolume& volume, const PiecewiseLinear& tilt, const std::vector<double>& tilt_at,
              const PiecewiseLinear& turn, const std::vector<double>& turn_at);

  bool reached() const { return tilt_.value.size() > 0; }
  /// What the tables of `samples` say at the reference pose; 0 where it is not reached.
  double of_tilt(const Eigen::VectorXd& samples) const;
  double of_turn(const Eigen::VectorXd& samples) const;

  Eigen::VectorXd tilt(const Eigen::VectorXd& samples) const;
  Eigen::VectorXd turn(const Eigen::VectorXd& samples) const;
  /// Rows over A, columns over C.
  Eigen::MatrixXd both(const Eigen::MatrixXd& samples, double value = 0) const;

 private:
  struct Along {
    Eigen::VectorXd value;  ///< of the table at 0, by its samples
    Eigen::VectorXd gives;  ///< y at the samples
  };
  Along tilt_, turn_;
};

/// What C's errors are at the reference pose where A's are `of_tilt` there and nothing is to be moved.
Vector6d against_tilt(const CompensationTask& task, const Vector6d& of_tilt);

}  // namespace trunnion
