#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "error.h"
#include "io/job_file.h"
#include "io/limits_file.h"

/// Any text is either a job of finite numbers, or refused by an Error; so are alarm limits.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace trunnion;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    for (const auto& [name, value] : parse_job(text, "fuzz.toml").covariates)
      if (!std::isfinite(value)) std::abort();
  } catch (const Error&) {
  }
  try {
    parse_limits(text, "fuzz.toml");
  } catch (const Error&) {
  }
  return 0;
}
