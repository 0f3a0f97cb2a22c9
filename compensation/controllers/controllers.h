#pragma once

#include "compensation/controller.h"

namespace trunnion {

// One controller a file of this folder.
Controller linuxcnc();
Controller isg_twincat();
Controller sinumerik_840d();
Controller aerotech();
Controller heidenhain();
Controller fanuc_30i();

}  // namespace trunnion
