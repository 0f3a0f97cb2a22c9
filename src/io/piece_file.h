#pragma once

#include <string>
#include <string_view>

#include "testpiece/measured_piece.h"

namespace trunnion {

/// A test piece file (TOML, CONTRACT: Test piece). Beyond the contract: tool.corner_radius_mm, tool.length_mm,
/// path.feed_mm_per_min. Left out, the heights are 2 mm from both ends and the middle, the points 360. Throws
/// InputError with file and line, what was found and what is wanted.
TestPiece read_piece(const std::string& path);
/// The same from text; `name` stands for the file in messages.
TestPiece parse_piece(std::string_view text, const std::string& name);

/// The text of a piece's file.
std::string piece_text(const TestPiece& piece);

/// A measured piece (CSV: phi_deg, h_mm, deviation_um; sigma_um of a point, and further numeric columns, where there
/// are any). Throws InputError with file, line and column; also for a trace that does not go round.
MeasuredPiece read_measured_piece(const std::string& path, const TestPiece& piece);
MeasuredPiece parse_measured_piece(std::string_view text, const std::string& name, const TestPiece& piece);

}  // namespace trunnion
