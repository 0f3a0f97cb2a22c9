#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "testpiece/colour_scale.h"

namespace trunnion {

/// Coloured triangles as glTF wants them: metres, Y up, which is (x, z, -y) of W.
struct Mesh {
  std::vector<std::array<float, 3>> position, normal;
  std::vector<std::array<std::uint8_t, 4>> colour;
  std::vector<std::uint32_t> index;

  /// A vertex; its number comes back.
  std::uint32_t add(const Eigen::Vector3d& point_w_mm, const Eigen::Vector3d& normal_w, Colour c);
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) { index.insert(index.end(), {a, b, c}); }
  /// The corners in order, seen from where the normal points to.
  void quad(const std::array<Eigen::Vector3d, 4>& corners_w_mm, const Eigen::Vector3d& normal_w, Colour c);
};

/// A named mesh of a scene.
struct NamedMesh {
  const char* name;
  Mesh mesh;
};

/// The meshes as a binary glTF 2.0 file (GLB), a node each; `extras` stand in its asset as numbers.
std::string glb_text(const std::vector<NamedMesh>& meshes, const std::vector<std::pair<const char*, double>>& extras);

}  // namespace trunnion
