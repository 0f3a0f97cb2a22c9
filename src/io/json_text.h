#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace trunnion {

/// JSON as text for people: objects one key a line with what names it first, lists of numbers on one line,
/// numbers in shortest round-trip form. Ends in a newline. A number that is not finite becomes null.
std::string json_text(const nlohmann::json& value);

constexpr std::size_t kLargestJson_bytes = std::size_t{1} << 28;

/// JSON read strictly: what the library lets pass is refused too, repeated keys and nesting without end; so are more
/// than kLargestJson_bytes, 2^16 objects, 2^20 keys, 2^24 values or 2^20 blanks at a stretch, so that time and memory
/// (2 GB) stay bounded. Throws InputError with line and column; `name` stands for the file in messages.
nlohmann::json parse_json(std::string_view text, const std::string& name);

}  // namespace trunnion
