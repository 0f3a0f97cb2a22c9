#pragma once

#include <string>
#include <vector>

#include "units/number_text.h"

namespace trunnion {

/// Lines of cells as text with aligned columns: the first column to the left, the others to the right, two blanks
/// between.
std::string text_table(const std::vector<std::vector<std::string>>& rows);

}  // namespace trunnion
