#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "error.h"
#include "io/piece_file.h"

/// Any text is either a piece, or what was measured of one in finite numbers, or refused by an Error.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace trunnion;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const TestPiece piece = parse_piece(text, "fuzz.toml");
    if (!(piece.cone.height.in_millimetres() > 0)) std::abort();
  } catch (const Error&) {
  }
  try {
    for (const MeasuredPoint& point : parse_measured_piece(text, "fuzz.csv", TestPiece{}).points)
      if (!std::isfinite(point.deviation_mm) || !std::isfinite(point.phi.in_radians())) std::abort();
  } catch (const Error&) {
  }
  return 0;
}
