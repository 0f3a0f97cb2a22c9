#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinematics/indexed_position.h"

namespace trunnion {

/// What kind of reading is being taken in a situation; none while cutting or evaluating. A point of a measured piece
/// (surface) was read elsewhere: its situation is the moment at which it was cut, and has none.
enum class ReadingKind { none, contact, displacement, rotation, pose, surface };

/// Named numeric columns that a data file carries beyond the known ones.
struct ExtraColumns {
  const std::vector<std::string>* names = nullptr;
  const double* values = nullptr;  ///< one per name
};

/// Everything an effect may depend on at one moment: where the machine stands, what it touches, and what is known of
/// the moment. The defaults are the zero of every effect: time 0, 20 deg C, both rotary axes last moved in the positive
/// sense.
struct Situation {
  IndexedPosition at;
  Eigen::Vector3d point_r_mm = Eigen::Vector3d::Zero();    ///< the tool point (contact point, ball, tip) in R
  Eigen::Vector3d approach_r = Eigen::Vector3d::Zero();    ///< unit approach into the face, zero if nothing is touched
  Eigen::Vector3d linear_sense = Eigen::Vector3d::Zero();  ///< sense of the last motion of X, Y, Z: -1, 0 (unknown), 1
  double tool_length_mm = 0;
  int tilt_sense = 1;  ///< A_dir
  int turn_sense = 1;  ///< C_dir
  double time_s = 0;
  double temperature_C = 20;
  int repeat = 0;             ///< pass within its file
  double order = 0;           ///< running number of the reading, from 0
  double order_in_pose = 0;   ///< running number since the machine came to this indexed position
  std::string_view point;     ///< label of the probed spot
  std::string_view artifact;  ///< label of the body it belongs to
  ReadingKind reading = ReadingKind::none;
  ExtraColumns extra;

  /// The covariate of that name: `time_s`, `temperature_C`, `A_dir`, `C_dir`, `repeat`, `order`, `order_in_pose`,
  /// `x_mm` …, `nx` …, `A_deg`, `C_deg`, or an extra column. Empty if the situation does not know it.
  std::optional<double> covariate(std::string_view name) const;
};

}  // namespace trunnion
