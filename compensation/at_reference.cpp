#include "compensation/at_reference.h"

#include <Eigen/LU>

#include "model/joint_motion.h"

namespace trunnion {
namespace {

Matrix6d twist_of_joint(const CompensationTask& task, std::size_t joint, Angle tilt) {
  Situation s;
  s.at.a = tilt;
  return joint_twist(task.chain, joint, s);
}

}  // namespace

AtReference::AtReference(const WorkingVolume& volume, const PiecewiseLinear& tilt, const std::vector<double>& tilt_at,
                         const PiecewiseLinear& turn, const std::vector<double>& turn_at) {
  const std::optional<double> zero = reference_deg(volume);
  if (!zero) return;
  const auto along = [&](const PiecewiseLinear& function, const std::vector<double>& at) {
    const Eigen::VectorXd y = function.yielding(at, *zero);
    Along a{function.projector(at).transpose() * function.weights(*zero),
            Eigen::VectorXd(static_cast<Eigen::Index>(at.size()))};
    for (std::size_t s = 0; s < at.size(); ++s) a.gives[static_cast<Eigen::Index>(s)] = function.weights(at[s]).dot(y);
    return a;
  };
  tilt_ = along(tilt, tilt_at);
  turn_ = along(turn, turn_at);
}

double AtReference::of_tilt(const Eigen::VectorXd& samples) const { return reached() ? tilt_.value.dot(samples) : 0; }

double AtReference::of_turn(const Eigen::VectorXd& samples) const { return reached() ? turn_.value.dot(samples) : 0; }

Eigen::VectorXd AtReference::tilt(const Eigen::VectorXd& samples) const {
  return reached() ? Eigen::VectorXd(samples - of_tilt(samples) * tilt_.gives) : samples;
}

Eigen::VectorXd AtReference::turn(const Eigen::VectorXd& samples) const {
  return reached() ? Eigen::VectorXd(samples - of_turn(samples) * turn_.gives) : samples;
}

Eigen::MatrixXd AtReference::both(const Eigen::MatrixXd& samples, double value) const {
  if (!reached()) return samples;
  const double there = tilt_.value.dot(samples * turn_.value);
  return samples + (value - there) * tilt_.gives * turn_.gives.transpose();
}

Vector6d against_tilt(const CompensationTask& task, const Vector6d& of_tilt) {
  return -twist_of_joint(task, task.chain.turn_index(), Angle()).inverse() *
         twist_of_joint(task, task.chain.tilt_index(), Angle()) * of_tilt;
}

}  // namespace trunnion
