#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace trunnion {

/// JSON as text for people: objects one key a line with what names it first, lists of numbers on one line,
/// numbers in shortest round-trip form. Ends in a newline. A number that is not finite becomes null.
std::string json_text(const nlohmann::json& value);

}  // namespace trunnion
