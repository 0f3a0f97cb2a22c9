#include "io/provenance.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "io/sha256.h"
#include "io/text_file.h"

namespace trunnion {

std::string program_version() { return "trunnion " TRUNNION_VERSION; }

nlohmann::json provenance_json(const std::vector<std::string>& inputs) {
  nlohmann::json hashes = nlohmann::json::object();
  for (const std::string& path : inputs) {
    nlohmann::json& hash = hashes[path.substr(path.find_last_of('/') + 1)];
    if (std::filesystem::is_regular_file(path)) hash = sha256_hex(read_text(path));
  }
  return {{"program", program_version()}, {"inputs_sha256", std::move(hashes)}};
}

}  // namespace trunnion
