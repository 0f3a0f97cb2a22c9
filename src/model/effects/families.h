#pragma once

#include "model/catalogue.h"

namespace trunnion {

/// @{ One family of effects, from the file of this folder that has its name (docs/effects.md).
Family rotary_error_map_family();
Family location_errors_family();
Family linear_scale_family();
Family backlash_family();
Family squareness_family();
Family straightness_family();
Family linear_angular_family();
Family linear_periodic_family();
Family linear_backlash_family();
Family cyclic_error_family();
Family brake_clamp_family();
Family payload_sag_family();
Family thermal_drift_family();
Family temperature_family();
Family probe_lobing_family();
Family probe_pretravel_family();
Family probe_settling_family();
Family artifact_expansion_family();
Family artifact_slip_family();
Family artifact_creep_family();
Family artifact_flex_family();
Family pass_shift_family();
Family smooth_family();
/// @}
}  // namespace trunnion
