#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "error.h"
#include "io/machine_file.h"
#include "io/observation_file.h"

namespace {

const trunnion::Machine& machine() {
  static const trunnion::Machine it = trunnion::parse_machine(
      "format = \"trunnion-machine\"\nversion = 1\nname = \"fuzz\"\nserial = \"1\"\nstructure = \"w C' A' Y' b X Z "
      "t\"\n",
      "fuzz.toml");
  return it;
}

}  // namespace

/// Any text is either observations without a NaN and with labels that exist, or refused by an Error.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace trunnion;
  try {
    const ObservationSet set = parse_observations({reinterpret_cast<const char*>(data), size}, "fuzz.csv", machine());
    for (const Observation& row : set.rows) {
      const bool finite = std::isfinite(row.value) && row.position_mm.allFinite() && row.direction.allFinite() &&
                          row.orientation.coeffs().allFinite() && std::isfinite(row.time_s);
      if (!finite || (!set.points.empty() && row.point >= set.points.size())) std::abort();
    }
    if (set.extra_values.size() != set.rows.size() * set.extra_columns.size()) std::abort();
    (void)pose_groups(set);
  } catch (const Error&) {
  }
  return 0;
}
