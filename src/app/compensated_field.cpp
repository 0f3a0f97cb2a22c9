#include "app/compensated_field.h"

namespace trunnion {

using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;

PoseError CompensatedField::at(const Situation& situation) const {
  const AxisCorrection added = played_->at(situation);
  Situation there = situation;
  there.at.a = situation.at.a + Angle::radians(added.tilt_rad);
  there.at.c = situation.at.c + Angle::radians(added.turn_rad);
  const Isometry3d w_before = chain_.r_from_w(situation.at), w_there = chain_.r_from_w(there.at);
  const Isometry3d workpiece = transform(errors_.at(there)) * w_there * w_before.inverse();
  // The tool's reference point stands where the slides carry it; its rotary axes turn about lines told from there.
  const Isometry3d t_before = chain_.r_from_t(situation.at), t_there = chain_.r_from_t(there.at);
  const Vector3d slides = situation.point_r_mm - t_before * Vector3d(0, 0, -situation.tool_length_mm);
  const Isometry3d tool =
      Translation3d(slides + added.linear_mm) * t_there * t_before.inverse() * Translation3d(-slides);
  return pose_error(tool.inverse() * workpiece);
}

}  // namespace trunnion
