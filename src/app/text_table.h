#pragma once

#include <string>
#include <vector>

namespace trunnion {

/// Lines of cells as text with aligned columns: the first column to the left, the others to the right, two blanks
/// between.
std::string text_table(const std::vector<std::vector<std::string>>& rows);

/// printf-style, for one number.
std::string formatted(const char* format, double value);

/// A value with its standard uncertainty, both to the uncertainty's second significant digit: "-12.34 +- 0.21".
std::string with_uncertainty(double value, double std);

}  // namespace trunnion
