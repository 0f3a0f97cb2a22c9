#pragma once

#include <string>
#include <vector>

#include "support/observation_row.h"
#include "support/smooth_machine.h"
#include "support/virtual_machine.h"

namespace trunnion::testing {

/// The trunnion of the sample calibration: EAA grows smoothly from 0 at A = 0 to 2e-3 deg at A = -90, the tilts EAC and
/// EBC stay within 0.5e-3 deg, the other errors are a few um and urad, with location errors among them.
VirtualMachine replica_machine();

/// Its calibration on replica_plan(): columns standing up to 20 um off and 50 urad askew, sigma 0.175 um, seed
/// 20100521.
std::vector<ObservationRow> replica_observations();

/// Its maps on the calibrated grid.
GaugedMaps replica_truth();

/// Maps as CSV: one row per (A, C) with the twelve errors and the pose error, um and urad.
std::string truth_csv(const GaugedMaps& maps, int decimals);

}  // namespace trunnion::testing
