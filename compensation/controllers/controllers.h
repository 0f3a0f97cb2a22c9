#pragma once

#include "compensation/controller.h"

namespace trunnion {

/// @{ What the catalogue knows of one controller, from the file of this folder that has its name.
Controller linuxcnc();
Controller isg_twincat();
Controller sinumerik_840d();
Controller aerotech();
Controller heidenhain();
Controller fanuc_30i();
/// @}
}  // namespace trunnion
