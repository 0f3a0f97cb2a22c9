#include <cstddef>
#include <cstdint>
#include <string_view>

#include "error.h"
#include "io/machine_file.h"

/// Any text is either a machine whose chain can be built, or refused by an Error.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    trunnion::parse_machine({reinterpret_cast<const char*>(data), size}, "fuzz.toml");
  } catch (const trunnion::Error&) {
  }
  return 0;
}
