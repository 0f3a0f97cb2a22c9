#pragma once

#include <string>
#include <vector>

namespace trunnion {

/// How a check of conventions came out. `open`: only the machine itself can tell, or these data do not.
enum class Outcome { passed, open, warning, failed };

/// The word for it in tables and JSON.
constexpr const char* outcome_text(Outcome outcome) {
  switch (outcome) {
    case Outcome::passed:
      return "passed";
    case Outcome::open:
      return "open";
    case Outcome::warning:
      return "warning";
    case Outcome::failed:
      return "FAILED";
  }
  return "";
}

/// One executable check: what was looked at, what was found with its numbers, and what to do about it.
struct Check {
  std::string id;  ///< "senses.A", "units.angles" …
  Outcome outcome = Outcome::passed;
  std::string found;
  std::string advice;  ///< empty where nothing is to be done
};

using Checks = std::vector<Check>;

}  // namespace trunnion
