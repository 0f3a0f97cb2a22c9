#pragma once

#include <array>
#include <string>
#include <vector>

#include "compensation/controller.h"

namespace trunnion {

/// Everything that the kinematics component of LinuxCNC knows of one machine: what stands in its source as data.
struct KinematicsData {
  double tilt_sense = 1, turn_sense = 1;  ///< +1: the table turns right-handed about +X, +Z as the command grows
  std::array<double, 2> turn_axis_mm{};   ///< X, Y of the C axis in R at A = C = 0
  std::array<double, 2> tilt_axis_mm{};   ///< Y, Z of the A axis in R
  double largest_turn_change_deg = 0.1;   ///< limits.correction_C_deg
  /// Coefficients of cubic B-splines on even knots, periodic in C: [(i * turn_count + j) * 6 + component], i counting
  /// the tilt_count = cells + 3 splines whose knots begin one step below tilt_low_deg. mm and rad, the table's pose
  /// error at R's origin.
  double tilt_low_deg = 0, tilt_step_deg = 1;
  std::size_t tilt_count = 0, turn_count = 0;
  std::vector<double> map;
  /// Alike along X, Y, Z in mm: nine numbers a spline, a twist of the table and a deviation of the tip; count 0: none.
  struct Linear {
    double low_mm = 0, step_mm = 1;
    std::size_t count = 0;
    std::vector<double> splines;
    friend bool operator==(const Linear&, const Linear&) = default;
  };
  std::array<Linear, 3> linear;
  friend bool operator==(const KinematicsData&, const KinematicsData&) = default;
};

/// What the component is given of a task: the map on splines a `spacing` apart in A and C.
KinematicsData kinematics_data(const CompensationTask& task, Angle spacing);

/// trunnion_kins.comp, complete; and the data in such a file. The latter throws InputError.
std::string component_source(const KinematicsData& data, const std::string& provenance);
KinematicsData read_component_data(const TableFile& file);

/// A joint compensation table of LinuxCNC, type 1: corrections while moving up and while moving down.
struct JointTable {
  /// A line of the file: the position, and what is added to it on either way.
  struct Row {
    double nominal = 0, forward = 0, reverse = 0;
    friend bool operator==(const Row&, const Row&) = default;
  };
  std::vector<Row> rows;  ///< degrees
  friend bool operator==(const JointTable&, const JointTable&) = default;
};
std::string joint_table_text(const JointTable& table, Emission emission);
/// As the control reads it: up to the first line that does not begin with three numbers. Throws InputError for what it
/// refuses with a message: nominals that do not ascend, more than 256 entries.
JointTable read_joint_table(const TableFile& file);
/// The correction at `position` for the sense of the last motion: linear between entries, the end entry held, values
/// and slopes in single precision.
double joint_correction(const JointTable& table, double position, int sense);

/// LinuxCNC with the files of one set loaded, the kinematics or the joint tables. Throws InputError for files that are
/// neither, or that the control refuses.
std::unique_ptr<PlayedCompensation> play_linuxcnc(const std::vector<TableFile>& files, const CompensationTask& task);

}  // namespace trunnion
