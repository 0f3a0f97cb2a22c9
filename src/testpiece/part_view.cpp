#include "testpiece/part_view.h"

#include <algorithm>
#include <cmath>

#include "testpiece/colour_bar.h"
#include "testpiece/colour_scale.h"

namespace trunnion {
namespace {

using Eigen::Vector3d;

constexpr Colour kGrey = {160, 160, 160};

/// A disc within a closed row of points, facing along `normal`; the points run right-handed about it or, with `up` -1,
/// left-handed.
void add_disc(Mesh& mesh, std::span<const Vector3d> rim_w_mm, const Vector3d& normal, int up) {
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& p : rim_w_mm) middle += p / static_cast<double>(rim_w_mm.size());
  const std::uint32_t first = mesh.add(middle, normal, kGrey) + 1;
  for (const Vector3d& p : rim_w_mm) mesh.add(p, normal, kGrey);
  const auto n = static_cast<std::uint32_t>(rim_w_mm.size());
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t here = first + k, next = first + (k + 1) % n;
    if (up > 0)
      mesh.triangle(first - 1, here, next);
    else
      mesh.triangle(first - 1, next, here);
  }
}

}  // namespace

std::string part_glb(const TestPiece& piece, const SurfaceGrid& surface, std::span<const double> deviation_mm,
                     double end_um, double magnification) {
  Mesh mesh;
  const std::size_t n = surface.phi_rad.size(), rows = surface.h_mm.size();
  std::vector<Vector3d> shown;
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    const ConePoint& on = surface.points[i];
    shown.push_back(on.point_w_mm + magnification * deviation_mm[i] * on.normal_w);
    mesh.add(shown.back(), on.normal_w, deviation_colour(1e3 * deviation_mm[i] / end_um));
  }
  for (std::size_t j = 0; j + 1 < rows; ++j)
    for (std::size_t k = 0; k < n; ++k) {
      const auto at = [&](std::size_t row, std::size_t column) {
        return static_cast<std::uint32_t>(row * n + column % n);
      };
      mesh.triangle(at(j, k), at(j, k + 1), at(j + 1, k + 1));
      mesh.triangle(at(j, k), at(j + 1, k + 1), at(j + 1, k));
    }
  const Vector3d axis = w_from_cone(piece.cone).linear().col(2);
  add_disc(mesh, std::span(shown).last(n), axis, 1);
  add_disc(mesh, std::span(shown).first(n), -axis, -1);

  Eigen::AlignedBox3d box;
  for (const Vector3d& p : shown) box.extend(p);
  const double size = std::max(box.sizes().z(), 0.5 * piece.cone.base_diameter.in_millimetres());
  const Vector3d foot(box.max().x() + 0.3 * size, box.center().y(), box.min().z());
  return glb_text({{"cone frustum", std::move(mesh)}, {"colour bar", colour_bar(end_um, magnification, foot, size)}},
                  {{"scale_um", end_um}, {"magnification", magnification}});
}

}  // namespace trunnion
