#include "testpiece/piece_solid.h"

#include "error.h"
#include "loaded_module.h"
#include "testpiece/brep/brep.h"

namespace trunnion {
namespace {

constexpr double kBlockHeight_mm = 20;
constexpr double kBlockSide = 0.65;  ///< of the base's diameter: the corners lie within the base's circle

/// The module stays loaded: OpenCASCADE does not take kindly to being unloaded.
void* function(const std::string& module, const char* name) {
  return module_function(module, name, "the solid modeller");
}

TrunnionBrepFrustum frustum_of(const TestPiece& piece) {
  const Eigen::Isometry3d frame = w_from_cone(piece.cone);
  TrunnionBrepFrustum frustum{.half_angle_rad = piece.cone.half_angle.in_radians(),
                              .base_diameter_mm = piece.cone.base_diameter.in_millimetres(),
                              .height_mm = piece.cone.height.in_millimetres(),
                              .base_center_mm = {},
                              .axis = {},
                              .zero = {},
                              .block_side_mm = kBlockSide * piece.cone.base_diameter.in_millimetres(),
                              .block_height_mm = kBlockHeight_mm};
  for (Eigen::Index k = 0; k < 3; ++k) {
    frustum.base_center_mm[k] = frame.translation()[k];
    frustum.axis[k] = frame.linear()(k, 2);
    frustum.zero[k] = frame.linear()(k, 0);
  }
  return frustum;
}

Eigen::Vector3d vector(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

}  // namespace

std::string piece_step(const TestPiece& piece, const std::string& module) {
  const auto step = reinterpret_cast<TrunnionBrepStep>(function(module, kTrunnionBrepStep));
  const TrunnionBrepFrustum frustum = frustum_of(piece);
  std::string text;
  char problem[256] = "";
  const auto append = [](void* target, const char* part, std::size_t size) {
    static_cast<std::string*>(target)->append(part, size);
  };
  if (step(&frustum, append, &text, problem, sizeof problem) != 0)
    throw ModelError(std::string("the piece makes no solid: ") + problem);
  return text;
}

Rulings solid_rulings(const TestPiece& piece, const std::string& module) {
  const auto open = reinterpret_cast<TrunnionBrepFlankOpen>(function(module, kTrunnionBrepFlankOpen));
  const auto at = reinterpret_cast<TrunnionBrepFlankAt>(function(module, kTrunnionBrepFlankAt));
  const auto close = reinterpret_cast<TrunnionBrepFlankClose>(function(module, kTrunnionBrepFlankClose));
  const TrunnionBrepFrustum frustum = frustum_of(piece);
  char problem[256] = "";
  const std::shared_ptr<void> flank(open(&frustum, problem, sizeof problem), close);
  if (!flank) throw ModelError(std::string("the piece makes no solid: ") + problem);
  return [=](Angle phi) {
    TrunnionBrepRuling ruling;
    at(flank.get(), phi.in_radians(), &ruling);
    return ConePoint{vector(ruling.point_mm), vector(ruling.normal), vector(ruling.along)};
  };
}

std::string brep_module() { return module_path("trunnion_brep", TRUNNION_LIBDIR); }

MeasuredSolid measured_solid(const std::string& step, const std::string& module) {
  const auto measure = reinterpret_cast<TrunnionBrepMeasure>(function(module, kTrunnionBrepMeasure));
  MeasuredSolid found;
  double semi_angle = 0;
  char problem[256] = "";
  if (measure(step.data(), step.size(), &found.volume_mm3, &found.faces, &semi_angle, problem, sizeof problem) != 0)
    throw ModelError(std::string("the solid cannot be read: ") + problem);
  found.semi_angle = Angle::radians(semi_angle);
  return found;
}

}  // namespace trunnion
