#pragma once

#include <Eigen/Core>
#include <optional>

#include "testpiece/cone_frustum.h"
#include "testpiece/tool_path.h"

namespace trunnion {

/// What a turning tool sweeps: a cylinder above its tip, the lower edge rounded by the corner radius (0: square, the
/// tool's radius: a ball). It is convex and has no upper end.
struct ToolSolid {
  double radius_mm = 0;
  double corner_mm = 0;
};
ToolSolid solid_of(const FlankTool& tool);

/// Parameters t of a line, mm, between which it is inside.
struct RayInterval {
  double in_mm;
  double out_mm;  ///< infinity where the ray leaves through the open top
};

/// Where the line point + t direction (unit vector) runs inside the solid standing at `tool`; empty if it misses.
/// `out_mm` is that of the cylinder with a square lower edge.
std::optional<RayInterval> ray_through(const ToolSolid& solid, const ToolInWorkpiece& tool,
                                       const Eigen::Vector3d& point_mm, const Eigen::Vector3d& direction);

}  // namespace trunnion
