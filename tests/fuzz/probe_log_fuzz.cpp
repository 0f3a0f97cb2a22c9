#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "error.h"
#include "io/machine_file.h"
#include "io/observation_file.h"
#include "io/probe_program.h"

/// Any text is either a probing log, whose readings an observations file can hold, or refused by an Error.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace trunnion;
  static const Machine machine = parse_machine(
      "format = \"trunnion-machine\"\nversion = 1\nname = \"Rejection bench\"\nserial = \"0\"\n"
      "structure = \"w C' A' Y' b X Z t\"\n",
      "fuzz.toml");
  try {
    const ObservationSet set = parse_probe_log({reinterpret_cast<const char*>(data), size}, "fuzz.log", machine);
    for (const Observation& o : set.rows)
      if (!o.position_mm.allFinite() || std::abs(o.direction.norm() - 1) > 1e-9) std::abort();
    if (observations_text(set, 'A').empty()) std::abort();
  } catch (const Error&) {
  }
  return 0;
}
