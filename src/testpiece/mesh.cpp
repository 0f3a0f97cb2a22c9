#include "testpiece/mesh.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>

namespace trunnion {
namespace {

static_assert(std::endian::native == std::endian::little, "GLB is little-endian");

using nlohmann::json;

void append_bytes(std::string& out, const auto& value) {
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  out.append(bytes, sizeof value);
}

/// What a scene is made of, while meshes are added to it.
class Scene {
 public:
  void add(const NamedMesh& named) {
    constexpr int kFloat = 5126, kByte = 5121, kWord = 5125, kArrayBuffer = 34962, kElementBuffer = 34963;
    const Mesh& mesh = named.mesh;
    std::array<float, 3> low = mesh.position.front(), high = low;
    for (const auto& p : mesh.position)
      for (std::size_t c = 0; c < 3; ++c) low[c] = std::min(low[c], p[c]), high[c] = std::max(high[c], p[c]);
    const std::size_t first = accessors_.size();
    append(mesh.position, kArrayBuffer, {{"componentType", kFloat}, {"type", "VEC3"}, {"min", low}, {"max", high}});
    append(mesh.normal, kArrayBuffer, {{"componentType", kFloat}, {"type", "VEC3"}});
    append(mesh.colour, kArrayBuffer, {{"componentType", kByte}, {"type", "VEC4"}, {"normalized", true}});
    append(mesh.index, kElementBuffer, {{"componentType", kWord}, {"type", "SCALAR"}});
    const json primitive = {{"attributes", {{"POSITION", first}, {"NORMAL", first + 1}, {"COLOR_0", first + 2}}},
                            {"indices", first + 3},
                            {"material", 0},
                            {"mode", 4}};
    roots_.push_back(meshes_.size());
    nodes_.push_back({{"mesh", meshes_.size()}, {"name", named.name}});
    meshes_.push_back({{"primitives", json::array({primitive})}});
  }

  std::string glb(const json& extras) {
    json gltf;
    gltf["asset"] = {{"version", "2.0"}, {"generator", "trunnion"}, {"extras", extras}};
    gltf["scene"] = 0;
    gltf["scenes"] = json::array({{{"nodes", roots_}}});
    gltf["nodes"] = nodes_;
    gltf["meshes"] = meshes_;
    gltf["materials"] = json::array(
        {{{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0.8}}}, {"doubleSided", false}}});
    gltf["buffers"] = json::array({{{"byteLength", binary_.size()}}});
    gltf["bufferViews"] = views_;
    gltf["accessors"] = accessors_;
    std::string text = gltf.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    binary_.resize((binary_.size() + 3) / 4 * 4, '\0');

    std::string glb = "glTF";
    const auto word = [&](std::size_t value) { append_bytes(glb, static_cast<std::uint32_t>(value)); };
    word(2);
    word(12 + 8 + text.size() + 8 + binary_.size());
    word(text.size());
    glb += "JSON" + text;
    word(binary_.size());
    return glb + std::string("BIN\0", 4) + binary_;
  }

 private:
  template <class Item>
  void append(const std::vector<Item>& items, int target, json accessor) {
    views_.push_back({{"buffer", 0},
                      {"byteOffset", binary_.size()},
                      {"byteLength", items.size() * sizeof(Item)},
                      {"target", target}});
    accessor["bufferView"] = views_.size() - 1;
    accessor["count"] = items.size();
    accessors_.push_back(std::move(accessor));
    for (const Item& item : items) append_bytes(binary_, item);
  }

  json roots_ = json::array(), nodes_ = json::array(), meshes_ = json::array();
  json views_ = json::array(), accessors_ = json::array();
  std::string binary_;
};

}  // namespace

std::uint32_t Mesh::add(const Eigen::Vector3d& point_w_mm, const Eigen::Vector3d& normal_w, Colour c) {
  const auto turned = [](const Eigen::Vector3d& v) {
    return std::array<float, 3>{static_cast<float>(v.x()), static_cast<float>(v.z()), static_cast<float>(-v.y())};
  };
  position.push_back(turned(point_w_mm * 1e-3));
  normal.push_back(turned(normal_w));
  colour.push_back({c[0], c[1], c[2], 255});
  return static_cast<std::uint32_t>(position.size() - 1);
}

void Mesh::quad(const std::array<Eigen::Vector3d, 4>& corners_w_mm, const Eigen::Vector3d& normal_w, Colour c) {
  const std::uint32_t a = add(corners_w_mm[0], normal_w, c);
  for (std::size_t k = 1; k < 4; ++k) add(corners_w_mm[k], normal_w, c);
  triangle(a, a + 1, a + 2);
  triangle(a, a + 2, a + 3);
}

std::string glb_text(const std::vector<NamedMesh>& meshes, const std::vector<std::pair<const char*, double>>& extras) {
  Scene scene;
  for (const NamedMesh& mesh : meshes) scene.add(mesh);
  json numbers;
  for (const auto& [name, value] : extras) numbers[name] = value;
  return scene.glb(numbers);
}

}  // namespace trunnion
