#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "testpiece/tool_solid.h"

namespace trunnion {

/// A ray from a point of the nominal surface along its outward normal.
struct SurfaceRay {
  Eigen::Vector3d point_w_mm;
  Eigen::Vector3d normal_w;
};

/// Where a ray first meets the tool: mm from its point, positive is excess material, and the position of the path
/// that cuts there (of several alike the first). Infinite where nothing cuts.
struct FirstEntry {
  double entry_mm;
  std::size_t position;
};

/// What a tool leaves standing that has been at all positions of a path. Along a surface ray material remains up to
/// the first entry into any position's solid; that is the machined surface.
///
/// Positions are searched through a tree over their order in the path. A node knows the mean axis of its positions, a
/// segment from the tip up, and how far their axes stray from it; the distance of the ray's point to that segment, less
/// stray and tool radius, bounds every entry below.
class CutEnvelope {
 public:
  /// `reach_mm`: how far above their tips the tools are asked about, at least.
  CutEnvelope(std::vector<ToolInWorkpiece> tools, ToolSolid solid, double reach_mm);

  /// The first entry along each ray. Material is taken away from outside, so that entries which end deeper than
  /// `depth_mm` below the point do not count. Independent of the number of threads (0: all processors).
  std::vector<FirstEntry> first_entries(std::span<const SurfaceRay> rays, double depth_mm, unsigned threads = 0) const;

 private:
  struct Node {
    Eigen::Vector3d tip_mm;
    Eigen::Vector3d along_mm;  ///< from the tip to the far end
    double inverse_square;     ///< 1 / |along|^2
    double stray_mm;
  };
  Node node_over(std::size_t first, std::size_t last) const;
  double bound_mm(std::size_t node, const Eigen::Vector3d& point) const;
  void search_leaf(std::size_t leaf, const SurfaceRay& ray, double depth_mm, FirstEntry& best) const;
  FirstEntry search(const SurfaceRay& ray, double depth_mm, std::size_t hint) const;

  std::vector<ToolInWorkpiece> tools_;
  ToolSolid solid_;
  double reach_mm_;
  std::size_t leaves_ = 1;   ///< a power of two
  std::vector<Node> nodes_;  ///< a heap: children of n are 2n and 2n + 1, leaves from leaves_ on
};

}  // namespace trunnion
