#pragma once

#include <string>
#include <vector>

#include "identification/identify.h"

namespace trunnion {

/// "A -90", or "A -90 C 180" for a function of both axes.
std::string position_text(IndexedPosition at, char tilt, bool with_c);

/// Each error function at its largest, with its standard uncertainty and whether noise alone would give as much.
std::string errors_table(const std::vector<ErrorFinding>& errors, char tilt);

/// Every error at every node with its standard uncertainty.
std::string nodes_table(const RotaryErrorMap& map, char tilt);

/// The error that displaces a point 100 mm off the most.
const ErrorFinding& worst_error(const std::vector<ErrorFinding>& errors);

/// That error over its angle, drawn in braille: the tilting axis' over A, C's over C at the tilt where it is largest;
/// a curve through the nodes, whose bars reach
/// two standard uncertainties either way; bars alone where a node is not seen.
std::string worst_error_plot(const RotaryErrorMap& map, const std::vector<ErrorFinding>& errors, char tilt);

}  // namespace trunnion
