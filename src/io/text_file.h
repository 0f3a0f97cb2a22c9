#pragma once

#include <string>

namespace trunnion {

/// The whole of a file, or of a pipe. Throws InputError for what is missing, a folder, unreadable, or over
/// `most_bytes`.
std::string read_text(const std::string& path, std::size_t most_bytes = std::size_t{1} << 32);

}  // namespace trunnion
