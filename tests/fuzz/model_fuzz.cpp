#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "error.h"
#include "io/machine_file.h"
#include "io/model_file.h"

namespace {

const trunnion::Machine& machine() {
  static const trunnion::Machine it = trunnion::parse_machine(
      "format = \"trunnion-machine\"\nversion = 1\nname = \"Rejection bench\"\nserial = \"R-1\"\n"
      "structure = \"w C' A' Y' b X Z t\"\n",
      "fuzz.toml");
  return it;
}

}  // namespace

/// Any text is either a model that reads back as it was written, or refused by an Error.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace trunnion;
  try {
    const Model model = parse_model({reinterpret_cast<const char*>(data), size}, "fuzz.json", machine());
    const std::string written = model_text(model);
    if (parse_model(written, "written.json", machine()).effects.size() != model.effects.size()) std::abort();
  } catch (const Error&) {
  }
  return 0;
}
