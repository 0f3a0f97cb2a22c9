#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "compensation/verification.h"
#include "error.h"
#include "io/machine_file.h"

// One program a controller: TRUNNION_FUZZED_CONTROLLER names it.

namespace {

const trunnion::Machine& machine() {
  static const trunnion::Machine it = trunnion::parse_machine(
      "format = \"trunnion-machine\"\nversion = 1\nname = \"Rejection bench\"\nserial = \"R-1\"\n"
      "structure = \"w C' A' Y' b X Z t\"\n[work_volume]\nA_deg = [-90, 0]\n",
      "fuzz.toml");
  return it;
}

const trunnion::CompensationTask& task() {
  static const trunnion::Model nothing;
  static const trunnion::CompensationTask it(machine(), nothing, {},
                                             trunnion::controller_named(TRUNNION_FUZZED_CONTROLLER).questions);
  return it;
}

/// A set of the controller's own, of which the fuzzed text replaces one file.
const std::vector<trunnion::TableFile>& set() {
  static const auto it =
      trunnion::controller_named(TRUNNION_FUZZED_CONTROLLER).emit(task(), trunnion::Angle::degrees(30), {});
  return it;
}

}  // namespace

/// The first byte says which file of a set the rest of the text stands in for. Whatever it says, the control's reader
/// refuses it by an Error or plays it with numbers.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace trunnion;
  if (size == 0) return 0;
  std::vector<TableFile> files = set();
  files[data[0] % files.size()].text.assign(reinterpret_cast<const char*>(data + 1), size - 1);
  try {
    const auto played = controller_named(TRUNNION_FUZZED_CONTROLLER).play(files, task());
    Situation s;
    s.point_r_mm = {10, 20, 30};
    for (const double tilt : {-90.0, -31.0, 0.0})
      for (const double turn : {-10.0, 0.0, 123.0, 360.0}) {
        s.at = {Angle::degrees(tilt), Angle::degrees(turn)};
        if (played->at(s).linear_mm.hasNaN()) std::abort();
      }
  } catch (const Error&) {
  }
  return 0;
}
