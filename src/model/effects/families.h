#pragma once

#include "model/catalogue.h"

namespace trunnion {

// One function a file of this folder.
Family rotary_error_map_family();
Family location_errors_family();
Family linear_scale_family();
Family backlash_family();

}  // namespace trunnion
