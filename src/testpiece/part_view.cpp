#include "testpiece/part_view.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>

#include "testpiece/colour_scale.h"

namespace trunnion {
namespace {

static_assert(std::endian::native == std::endian::little, "GLB is little-endian");

using Eigen::Vector3d;

void append_bytes(std::string& out, const auto& value) {
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  out.append(bytes, sizeof value);
}

/// Vertices and triangles, as glTF wants them.
struct Mesh {
  std::vector<std::array<float, 3>> position, normal;
  std::vector<std::array<std::uint8_t, 4>> colour;
  std::vector<std::uint32_t> index;

  std::uint32_t add(const Vector3d& point_w_mm, const Vector3d& normal_w, Colour c) {
    const auto turned = [](const Vector3d& v) {
      return std::array<float, 3>{static_cast<float>(v.x()), static_cast<float>(v.z()), static_cast<float>(-v.y())};
    };
    position.push_back(turned(point_w_mm * 1e-3));
    normal.push_back(turned(normal_w));
    colour.push_back({c[0], c[1], c[2], 255});
    return static_cast<std::uint32_t>(position.size() - 1);
  }
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) { index.insert(index.end(), {a, b, c}); }
};

/// A disc square to the cone's axis at height h, facing along `up` times the axis.
void add_disc(Mesh& mesh, const TestPiece& piece, Length h, int up, std::size_t corners) {
  constexpr Colour kGrey = {160, 160, 160};
  const Eigen::Isometry3d frame = w_from_cone(piece.cone);
  const Vector3d axis = frame.linear().col(2);
  const std::uint32_t middle = mesh.add(frame.translation() + h.in_millimetres() * axis, up * axis, kGrey);
  const auto n = static_cast<std::uint32_t>(corners);
  for (std::size_t k = 0; k < corners; ++k) {
    const Angle phi = (static_cast<double>(k) / static_cast<double>(corners)) * kFullTurn;
    mesh.add(cone_point(piece.cone, frame, phi, h).point_w_mm, up * axis, kGrey);
  }
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t here = middle + 1 + k, next = middle + 1 + (k + 1) % n;
    if (up > 0)
      mesh.triangle(middle, here, next);
    else
      mesh.triangle(middle, next, here);
  }
}

}  // namespace

std::string part_glb(const TestPiece& piece, const SurfaceGrid& surface, std::span<const double> deviation_mm,
                     double magnification) {
  double largest = 0;
  for (const double d : deviation_mm) largest = std::max(largest, std::abs(d));
  const double end_um = round_scale(1e3 * largest);
  Mesh mesh;
  const std::size_t n = surface.phi_rad.size(), rows = surface.h_mm.size();
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    const ConePoint& on = surface.points[i];
    mesh.add(on.point_w_mm + magnification * deviation_mm[i] * on.normal_w, on.normal_w,
             deviation_colour(1e3 * deviation_mm[i] / end_um));
  }
  for (std::size_t j = 0; j + 1 < rows; ++j)
    for (std::size_t k = 0; k < n; ++k) {
      const auto at = [&](std::size_t row, std::size_t column) {
        return static_cast<std::uint32_t>(row * n + column % n);
      };
      mesh.triangle(at(j, k), at(j, k + 1), at(j + 1, k + 1));
      mesh.triangle(at(j, k), at(j + 1, k + 1), at(j + 1, k));
    }
  add_disc(mesh, piece, piece.cone.height, 1, 180);
  add_disc(mesh, piece, Length(), -1, 180);

  std::array<float, 3> low = mesh.position.front(), high = low;
  std::string binary;
  for (const auto& p : mesh.position)
    for (std::size_t c = 0; c < 3; ++c) low[c] = std::min(low[c], p[c]), high[c] = std::max(high[c], p[c]);
  const std::size_t count = mesh.position.size();
  for (const auto& p : mesh.position) append_bytes(binary, p);
  for (const auto& v : mesh.normal) append_bytes(binary, v);
  for (const auto& c : mesh.colour) append_bytes(binary, c);
  for (const std::uint32_t i : mesh.index) append_bytes(binary, i);

  using nlohmann::json;
  constexpr int kFloat = 5126, kByte = 5121, kWord = 5125, kArrayBuffer = 34962, kElementBuffer = 34963;
  const json views = {
      {{"buffer", 0}, {"byteOffset", 0}, {"byteLength", 12 * count}, {"target", kArrayBuffer}},
      {{"buffer", 0}, {"byteOffset", 12 * count}, {"byteLength", 12 * count}, {"target", kArrayBuffer}},
      {{"buffer", 0}, {"byteOffset", 24 * count}, {"byteLength", 4 * count}, {"target", kArrayBuffer}},
      {{"buffer", 0}, {"byteOffset", 28 * count}, {"byteLength", 4 * mesh.index.size()}, {"target", kElementBuffer}}};
  const json accessors = {
      {{"bufferView", 0}, {"componentType", kFloat}, {"count", count}, {"type", "VEC3"}, {"min", low}, {"max", high}},
      {{"bufferView", 1}, {"componentType", kFloat}, {"count", count}, {"type", "VEC3"}},
      {{"bufferView", 2}, {"componentType", kByte}, {"count", count}, {"type", "VEC4"}, {"normalized", true}},
      {{"bufferView", 3}, {"componentType", kWord}, {"count", mesh.index.size()}, {"type", "SCALAR"}}};
  const json primitive = {
      {"attributes", {{"POSITION", 0}, {"NORMAL", 1}, {"COLOR_0", 2}}}, {"indices", 3}, {"material", 0}, {"mode", 4}};
  json gltf;
  gltf["asset"] = {{"version", "2.0"},
                   {"generator", "trunnion"},
                   {"extras", {{"scale_um", end_um}, {"magnification", magnification}}}};
  gltf["scene"] = 0;
  gltf["scenes"] = json::array({{{"nodes", json::array({0})}}});
  gltf["nodes"] = json::array({{{"mesh", 0}, {"name", "cone frustum"}}});
  gltf["meshes"] = json::array({{{"primitives", json::array({primitive})}}});
  gltf["materials"] = json::array(
      {{{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0.8}}}, {"doubleSided", false}}});
  gltf["buffers"] = json::array({{{"byteLength", binary.size()}}});
  gltf["bufferViews"] = views;
  gltf["accessors"] = accessors;
  std::string text = gltf.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');

  std::string glb = "glTF";
  const auto word = [&](std::size_t value) { append_bytes(glb, static_cast<std::uint32_t>(value)); };
  word(2);
  word(12 + 8 + text.size() + 8 + binary.size());
  word(text.size());
  glb += "JSON" + text;
  word(binary.size());
  glb += std::string("BIN\0", 4) + binary;
  return glb;
}

}  // namespace trunnion
