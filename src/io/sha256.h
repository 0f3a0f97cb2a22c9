#pragma once

#include <string>
#include <string_view>

namespace trunnion {

/// SHA-256 of the bytes in small hexadecimal digits (FIPS 180-4).
std::string sha256_hex(std::string_view bytes);

}  // namespace trunnion
