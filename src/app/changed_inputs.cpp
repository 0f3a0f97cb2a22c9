#include "app/changed_inputs.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "io/model_file.h"
#include "io/sha256.h"
#include "io/text_file.h"

namespace trunnion {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// Where `digests` knows the file under `name` by another hash.
void compare_digest(const json& digests, const std::string& name, const std::string& path, const std::string& what,
                    std::vector<std::string>& lines) {
  if (!digests.is_object() || !digests.contains(name) || !digests[name].is_string() || !fs::is_regular_file(path))
    return;
  if (const std::string found = sha256_hex(read_text(path)); digests[name] != found)
    lines.push_back(path + ": changed, or another file of this name: its SHA-256 is " + found + ", " + what + " " +
                    digests[name].get<std::string>());
}

}  // namespace

std::vector<std::string> changed_inputs(const json& provenance, const std::string& result,
                                        const std::vector<std::string>& files) {
  std::vector<std::string> lines;
  if (!provenance.is_object() || !provenance.contains("inputs_sha256")) return lines;
  for (const std::string& file : files)
    compare_digest(provenance["inputs_sha256"], fs::path(file).filename().string(), file, result + " was made with",
                   lines);
  return lines;
}

std::vector<std::string> changed_inputs(const Model& model, const std::string& result,
                                        const std::vector<std::string>& files) {
  return model.fit ? changed_inputs(*model.fit, result, files) : std::vector<std::string>();
}

std::vector<std::string> changed_compensation(const std::string& path, const Machine& machine,
                                              const std::vector<std::string>& files) {
  if (fs::is_directory(path)) return changed_since_verified(path, files);
  return changed_inputs(read_model(path, machine), path, files);
}

std::vector<std::string> changed_since_verified(const std::string& folder, const std::vector<std::string>& files) {
  const fs::path summary = fs::path(folder) / "verification.json";
  if (!fs::is_regular_file(summary)) return {};
  const json verification = json::parse(read_text(summary.string()), nullptr, false);
  std::vector<std::string> lines = changed_inputs(verification, summary.string(), files);
  if (verification.is_object() && verification.contains("files_sha256") && verification["files_sha256"].is_object())
    for (const auto& [name, digest] : verification["files_sha256"].items())
      if (digest.is_string())
        compare_digest(verification["files_sha256"], name, (fs::path(folder) / name).string(), "verified was", lines);
  return lines;
}

}  // namespace trunnion
