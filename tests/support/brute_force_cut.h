#pragma once

#include <Eigen/Core>
#include <vector>

#include "support/virtual_machine.h"

namespace trunnion::testing {

/// A cutter: a cylinder with its lower edge rounded by `corner_mm`; 0 a square end, `radius_mm` a ball.
struct Cutter {
  double radius_mm = 10;
  double corner_mm = 0;
};

/// Whether a point of the workpiece is cut away by the cutter standing at `tool`.
bool cuts(const Cutter& cutter, const ToolInWorkpiece& tool, const Eigen::Vector3d& point_w_mm);

/// How much material is left on a surface point along its outward normal after the cutter has been everywhere in
/// `tools`: walks from `depth_mm` below the point outward by small steps, position by position, and halves the step in
/// which material first meets the cutter. Nothing is solved; slow.
double material_left_mm(const Cutter& cutter, const std::vector<ToolInWorkpiece>& tools,
                        const Eigen::Vector3d& point_w_mm, const Eigen::Vector3d& normal_w, double depth_mm = 1);

}  // namespace trunnion::testing
