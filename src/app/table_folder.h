#pragma once

#include <string>
#include <vector>

#include "compensation/controller.h"

namespace trunnion {

/// All files of a folder that `trunnion tables` wrote, by name. Throws InputError where there is no such folder.
std::vector<TableFile> files_in(const std::string& folder);

}  // namespace trunnion
