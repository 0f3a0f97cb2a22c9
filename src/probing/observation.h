#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "model/situation.h"

namespace trunnion {

/// One row of an observations file (CONTRACT: Observations), in inside units.
struct Observation {
  ReadingKind kind = ReadingKind::contact;
  std::uint32_t line = 0;      ///< in its file, from 1
  IndexedPosition at;          ///< as commanded
  std::uint32_t point = 0;     ///< index into ObservationSet::points
  std::uint32_t artifact = 0;  ///< index into ObservationSet::artifacts
  /// contact: contact point in R; displacement: the ball's nominal place in R; surface: where the point stood in R when
  /// it was cut; pose: origin of the target in the instrument's frame. mm
  Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
  /// contact: unit approach in R; displacement: sensing direction; surface: inward normal then; rotation: axis.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  double value =
      0;  ///< displacement: n . d, mm; rotation: rad; surface: excess material that the commands do not leave
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< pose: of the target in the instrument's frame
  int repeat = 0;
  double time_s = 0;
  int tilt_sense = 1;  ///< A_dir
  int turn_sense = 1;  ///< C_dir
  double temperature_C = 20;
  double sigma = 0;       ///< of this reading, mm (pose: mm; rotation: rad); 0: the machine file's
  std::uint32_t cut = 0;  ///< surface: index into ObservationSet::cuts
};

/// What the tool did when a point of a measured piece was cut, beyond what the row tells.
struct CutMoment {
  Eigen::Vector3d tip_r_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d linear_sense = Eigen::Vector3d::Zero();
  double tool_length_mm = 0;
  std::uint32_t stretch = 0;  ///< of the path: what is looked at, or kept back, together
};

/// The readings of one or more files, in the order taken, and what they carry.
struct ObservationSet {
  std::vector<std::string> files;
  std::vector<Observation> rows;
  std::vector<std::uint32_t> file_of_row;  ///< index into files; empty while there is one file
  std::vector<std::string> points;         ///< labels, in order of appearance
  std::vector<std::string> artifacts;
  std::vector<std::string> extra_columns;  ///< names of further numeric columns
  std::vector<double> extra_values;        ///< row-major, rows.size() x extra_columns.size()
  std::vector<CutMoment> cuts;
  bool has_time = false, has_temperature = false, has_tilt_sense = false, has_turn_sense = false, has_repeat = false,
       has_sigma = false;

  /// "file:line" of a row, for messages.
  std::string place(std::size_t row) const;
};

/// Both sets as one: labels common to both are the same spots, artifacts and columns; `time_s` runs on one clock. A
/// column that only one of them has is dropped unless it is a known one. Throws InputError if only one of them carries
/// time_s.
ObservationSet joined(const ObservationSet& first, const ObservationSet& second);

/// Readings and the points of a measured piece as one set. What only one of them carries (time_s, temperature_C, extra
/// columns) stands at its zero for the other.
ObservationSet joined_with_piece(const ObservationSet& readings, const ObservationSet& piece);

/// Situations of all rows: order and order_in_pose counted, linear senses from the approach. The labels and extra
/// values point into `set`, which must outlive them.
std::vector<Situation> situations(const ObservationSet& set);

/// Rows that stand at the same indexed position: A and C agree within 0.1 deg, C modulo 360 (CONTRACT); or those of one
/// stretch of a measured piece. In the order of first appearance.
struct PoseGroup {
  IndexedPosition at;  ///< mean of the commands, C unwrapped to [0, 360)
  std::vector<std::size_t> rows;
  bool reference = false;  ///< A = C = 0 within the tolerance
  bool moving = false;     ///< a stretch of a path: its rows share no pose error
};
/// Positions first, then the stretches of a path.
std::vector<PoseGroup> pose_groups(const ObservationSet& set);

}  // namespace trunnion
