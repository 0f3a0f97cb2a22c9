#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "testpiece/machining.h"

namespace trunnion {

/// What a measuring machine found at one point of a cone, along the outward normal of the nominal one.
struct MeasuredPoint {
  std::uint32_t line = 0;  ///< of its file
  Angle phi;
  Length h;
  double deviation_mm = 0;  ///< positive: excess material
  double sigma_mm = 0;      ///< 0: not told
};

/// A measured piece: its points, height by height or not, and further numbers that stand beside them.
struct MeasuredPiece {
  std::string file;
  std::vector<MeasuredPoint> points;
  std::vector<std::string> columns;
  std::vector<double> values;  ///< points.size() x columns.size(), row by row
};

/// One trace per height, ascending, points in the order of phi.
std::vector<ConeTrace> traces_of(const MeasuredPiece& measured, const TestPiece& piece);

/// The noise of a measured piece from what its neighbouring points tell of one another: the second difference along a
/// trace, whose root mean square is sqrt(6) sigma, by its median so that steps do not count. Zero where no trace has
/// five points.
double point_to_point_sigma_mm(std::span<const ConeTrace> traces);

/// Which points were cut in steady motion: every position of the path within the tool's contact came with the same
/// senses of motion, and soon before or after. Elsewhere several moments have part in what remains, and first order
/// does not hold for effects that know senses or time. `points` are those of the nominal surface, `cut` their
/// cut_points.
std::vector<bool> cut_steadily(const TestPiece& piece, std::span<const CutPoint> cut,
                               std::span<const ToolPosition> path);

}  // namespace trunnion
