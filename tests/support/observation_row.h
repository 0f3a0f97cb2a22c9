#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace trunnion::testing {

/// One row of an observation file, in the file's own units.
struct ObservationRow {
  std::string kind = "contact";
  double A_deg = 0;  ///< of B on a machine with B in place of A
  double C_deg = 0;
  std::string point;
  std::string artifact;
  std::optional<Eigen::Vector3d> xyz_mm;
  std::optional<Eigen::Vector3d> n;
  std::optional<double> value_um;
  std::optional<Eigen::Vector3d> m;
  std::optional<double> value_urad;
  std::optional<Eigen::Vector4d> quaternion_wxyz;
  std::optional<int> repeat;
  std::optional<double> time_s;
  std::optional<int> A_dir;
  std::optional<int> C_dir;
  std::optional<double> temperature_C;
  std::optional<double> sigma_um;
  std::map<std::string, double> covariates;
};

/// The rows as CSV text: header, the columns that at least one row has (`kind` only where a row is no contact), empty
/// fields where a row has not. Numbers in shortest round-trip form, or rounded to `decimals` with trailing zeros cut
/// off.
std::string csv(const std::vector<ObservationRow>& rows, std::optional<int> decimals = {}, char tilt_axis = 'A');

/// One number, as csv() writes it.
std::string csv_number(double value, std::optional<int> decimals = {});

}  // namespace trunnion::testing
