#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "compensation/controllers/linuxcnc.h"
#include "error.h"
#include "units/angle.h"

// LinuxCNC with the component loaded, told anew from what a trunnion does: a twin in other words, so that a slip in
// either shows.

namespace trunnion {
namespace {

/// Weight of the cubic B-spline centred at knot 0 (spacing 1), by its distance (de Boor 1978).
double spline_at(double distance) {
  const double t = std::abs(distance);
  if (t >= 2) return 0;
  if (t >= 1) return std::pow(2 - t, 3) / 6;
  return 2.0 / 3 - t * t + t * t * t / 2;
}

class Kinematics : public PlayedCompensation {
 public:
  Kinematics(KinematicsData data, std::optional<JointTable> tilt, std::optional<JointTable> turn)
      : data_(std::move(data)), tilt_table_(std::move(tilt)), turn_table_(std::move(turn)) {}

  AxisCorrection at(const Situation& s) const override {
    const double tilt = s.at.a.in_degrees(), turn = s.at.c.in_degrees();
    // The point of the work that is programmed, in the table's frame; the tool's axis there.
    const Eigen::Isometry3d nominal = table(tilt, turn);
    const Eigen::Vector3d work = nominal.inverse() * s.point_r_mm;
    const Eigen::Vector3d axis = nominal.linear().transpose() * Eigen::Vector3d::UnitZ();

    double tilt_change = 0, turn_change = 0, wish = 0;  // degrees, degrees, rad
    const double held_back = std::pow(std::sin(kDegree_rad), 2);
    for (int step = 0; step < 4; ++step) {
      const Eigen::Isometry3d there = table(tilt + tilt_change, turn + turn_change);
      const Eigen::Isometry3d real = error(tilt + tilt_change, turn + turn_change, there * work) * there;
      const Eigen::Vector3d seen = real.linear() * axis;  // should be +Z
      const double lever = (there.linear().transpose() * Eigen::Vector3d::UnitZ()).head<2>().norm() *
                           (std::sin(data_.tilt_sense * (tilt + tilt_change) * kDegree_rad) < 0 ? -1 : 1);
      wish += (seen.x() * lever - held_back * wish) / (lever * lever + held_back);
      const double cap = data_.largest_turn_change_deg * kDegree_rad;
      const double allowed = cap > 0 ? wish / std::pow(1 + std::pow(wish / cap, 8), 0.125) : 0;
      turn_change = data_.turn_sense * allowed / kDegree_rad;
      tilt_change += data_.tilt_sense * seen.y() / kDegree_rad;
    }
    const Eigen::Vector3d target = table(tilt + tilt_change, turn + turn_change) * work;
    Eigen::Vector3d tip = target;
    for (int step = 0; step < 3; ++step) tip = error(tilt + tilt_change, turn + turn_change, tip) * target;

    AxisCorrection correction{tip - s.point_r_mm, tilt_change * kDegree_rad, turn_change * kDegree_rad};
    // Joint tables act on what the kinematics ask of the joints.
    if (tilt_table_)
      correction.tilt_rad += kDegree_rad * joint_correction(*tilt_table_, tilt + tilt_change, s.tilt_sense);
    if (turn_table_)
      correction.turn_rad += kDegree_rad * joint_correction(*turn_table_, turn + turn_change, s.turn_sense);
    return correction;
  }

 private:
  Eigen::Isometry3d table(double tilt_deg, double turn_deg) const {
    const auto about = [](Eigen::Vector3d line, double angle, const Eigen::Vector3d& direction) {
      return Eigen::Translation3d(line) * Eigen::AngleAxisd(angle, direction) * Eigen::Translation3d(-line);
    };
    return about({0, data_.tilt_axis_mm[0], data_.tilt_axis_mm[1]}, data_.tilt_sense * tilt_deg * kDegree_rad,
                 Eigen::Vector3d::UnitX()) *
           about({data_.turn_axis_mm[0], data_.turn_axis_mm[1], 0}, data_.turn_sense * turn_deg * kDegree_rad,
                 Eigen::Vector3d::UnitZ());
  }

  Eigen::Isometry3d error(double tilt_deg, double turn_deg, const Eigen::Vector3d& p) const {
    Vector6d sum = Vector6d::Zero();
    const auto last = static_cast<double>(data_.tilt_count - 3);
    const double i = std::clamp((tilt_deg - data_.tilt_low_deg) / data_.tilt_step_deg, 0.0, last) + 1;
    const auto turns = static_cast<double>(data_.turn_count);
    const double j = turns * (turn_deg / 360 - std::floor(turn_deg / 360)) + 1;
    for (std::size_t row = 0; row < data_.tilt_count; ++row) {
      const double in_tilt = spline_at(i - static_cast<double>(row));
      if (in_tilt == 0) continue;
      for (int k = -1; k <= 2; ++k) {
        const double knot = std::floor(j) + k;
        const auto column = static_cast<std::size_t>(std::fmod(knot + turns, turns));
        const double weight = in_tilt * spline_at(j - knot);
        sum += weight * Eigen::Map<const Vector6d>(&data_.map[(row * data_.turn_count + column) * 6]);
      }
    }
    Eigen::Vector3d beside = Eigen::Vector3d::Zero();
    for (std::size_t n = 0; n < 3; ++n) {
      const KinematicsData::Linear& part = data_.linear[n];
      if (part.count == 0) continue;
      const double at = std::clamp((p[static_cast<Eigen::Index>(n)] - part.low_mm) / part.step_mm, 0.0,
                                   static_cast<double>(part.count - 3)) +
                        1;
      for (std::size_t k = 0; k < part.count; ++k) {
        const double weight = spline_at(at - static_cast<double>(k));
        if (weight == 0) continue;
        sum += weight * Eigen::Map<const Vector6d>(&part.splines[9 * k]);
        beside += weight * Eigen::Map<const Eigen::Vector3d>(&part.splines[9 * k + 6]);
      }
    }
    return Eigen::Translation3d(beside) * transform(PoseError::from_vector(sum));
  }

  KinematicsData data_;
  std::optional<JointTable> tilt_table_, turn_table_;
};

/// Stock kinematics with a table for each rotary joint.
class JointTables : public PlayedCompensation {
 public:
  JointTables(JointTable tilt, JointTable turn) : tilt_(std::move(tilt)), turn_(std::move(turn)) {}
  AxisCorrection at(const Situation& s) const override {
    return {Eigen::Vector3d::Zero(), kDegree_rad * joint_correction(tilt_, s.at.a.in_degrees(), s.tilt_sense),
            kDegree_rad * joint_correction(turn_, s.at.c.in_degrees(), s.turn_sense)};
  }

 private:
  JointTable tilt_, turn_;
};

}  // namespace

std::unique_ptr<PlayedCompensation> play_linuxcnc(const std::vector<TableFile>& files, const CompensationTask&) {
  const auto named = [&](const std::string& name) -> const TableFile* {
    const auto found = std::ranges::find(files, name, &TableFile::name);
    return found == files.end() ? nullptr : &*found;
  };
  const auto table = [&](const std::string& name) -> std::optional<JointTable> {
    const TableFile* file = named(name);
    return file == nullptr ? std::nullopt : std::optional(read_joint_table(*file));
  };
  // The default set first; the other is played only where it stands alone.
  if (const TableFile* component = named("kinematics/trunnion_kins.comp"))
    return std::make_unique<Kinematics>(read_component_data(*component), table("kinematics/joint_A.comp"),
                                        table("kinematics/joint_C.comp"));
  const TableFile* tilt = named("joint_tables/joint_A.comp");
  if (tilt == nullptr) tilt = named("joint_tables/joint_B.comp");
  const auto turn = table("joint_tables/joint_C.comp");
  if (tilt == nullptr || !turn)
    throw InputError("kinematics/trunnion_kins.comp", "missing, and so are joint_tables/joint_A.comp and joint_C.comp");
  return std::make_unique<JointTables>(read_joint_table(*tilt), *turn);
}

}  // namespace trunnion
