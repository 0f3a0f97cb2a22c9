#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "support/noise.h"
#include "support/virtual_machine.h"

namespace trunnion::testing {

/// A machine drawn from a seed. Error motions of the tilting axis: each of the six an amplitude times a random mix of
/// sin q, 1 - cos q and sin 2q. Of C: harmonics h = 1 ... C_harmonics with amplitudes falling as 1/h, the coefficients
/// of cos hC and sin hC varying with the tilt as a mix of 1, sin q and cos q. Location errors: random constants.
struct SmoothMachineOptions {
  double translation_mm = 4e-3;  ///< standard deviation of one coefficient of an error motion; 0: none
  double rotation_rad = 20e-6;
  int C_harmonics = 2;
  double location_mm = 10e-3;  ///< standard deviation of EY0A EZ0A EX0C EY0C; 0: none
  double location_rad = 30e-6;
};
VirtualMachine smooth_machine(std::uint64_t seed, const SmoothMachineOptions& options = {},
                              const std::string& structure = "w C' A' Y' b X Z t");

/// Location errors and nothing else.
VirtualMachine location_errors_only(std::uint64_t seed, const std::string& structure = "w C' A' Y' b X Z t");

/// The error maps that a perfect measurement at these stations gives, for a machine with both rotary axes under the
/// table: pose errors T(Delta) = T(A,C) T(0,0)^-1 T~^-1, split by Eq. (12) and (13) into the tilting axis' mean over C
/// and the remainder, each taken at its own axis' origin.
struct GaugedMaps {
  std::vector<double> tilt_deg;
  std::vector<double> C_deg;
  std::vector<AxisErrors> tilt;  ///< one per tilt station
  std::vector<AxisErrors> C;     ///< row by row: [i * C_deg.size() + j]
  std::vector<AxisErrors> pose;  ///< Delta at R's origin, likewise
};
GaugedMaps gauged_maps(const VirtualMachine& machine, const std::vector<double>& tilt_deg,
                       const std::vector<double>& C_deg);

}  // namespace trunnion::testing
