#include "testpiece/cut_envelope.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "testpiece/parallel.h"

namespace trunnion {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kLeaf = 8;  ///< positions in a leaf
constexpr double kNowhere_mm = std::numeric_limits<double>::infinity();

}  // namespace

CutEnvelope::CutEnvelope(std::vector<ToolInWorkpiece> tools, ToolSolid solid, double reach_mm)
    : tools_(std::move(tools)), solid_(solid), reach_mm_(reach_mm) {
  while (leaves_ * kLeaf < tools_.size()) leaves_ *= 2;
  nodes_.resize(2 * leaves_);
  for (std::size_t level = leaves_, width = kLeaf; level > 0; level /= 2, width *= 2)
    for (std::size_t k = 0; k < level; ++k) nodes_[level + k] = node_over(k * width, (k + 1) * width);
}

CutEnvelope::Node CutEnvelope::node_over(std::size_t first, std::size_t last) const {
  first = std::min(first, tools_.size()), last = std::min(last, tools_.size());
  Node node{Vector3d::Zero(), Vector3d::UnitZ(), 1, -kNowhere_mm};
  if (first == last) return node;
  Vector3d tip = Vector3d::Zero(), far = Vector3d::Zero();
  for (std::size_t i = first; i < last; ++i) {
    tip += tools_[i].tip_w_mm;
    far += tools_[i].tip_w_mm + reach_mm_ * tools_[i].axis_w;
  }
  const auto count = static_cast<double>(last - first);
  node.tip_mm = tip / count;
  node.along_mm = far / count - node.tip_mm;
  node.inverse_square = 1 / std::max(node.along_mm.squaredNorm(), 1e-12);
  node.stray_mm = 0;
  for (std::size_t i = first; i < last; ++i) {
    const Vector3d off = tools_[i].tip_w_mm - node.tip_mm;
    node.stray_mm = std::max({node.stray_mm, off.norm(), (off + reach_mm_ * tools_[i].axis_w - node.along_mm).norm()});
  }
  return node;
}

double CutEnvelope::bound_mm(std::size_t index, const Vector3d& point) const {
  const Node& node = nodes_[index];
  if (node.stray_mm < 0) return kNowhere_mm;  // no position at all
  const Vector3d off = point - node.tip_mm;
  const double share = std::clamp(off.dot(node.along_mm) * node.inverse_square, 0.0, 1.0);
  return (off - share * node.along_mm).norm() - node.stray_mm - solid_.radius_mm;
}

void CutEnvelope::search_leaf(std::size_t leaf, const SurfaceRay& ray, double depth_mm, FirstEntry& best) const {
  const std::size_t last = std::min((leaf + 1) * kLeaf, tools_.size());
  for (std::size_t i = leaf * kLeaf; i < last; ++i) {
    // No entry comes before the point's own distance from the tool.
    const Vector3d off = ray.point_w_mm - tools_[i].tip_w_mm;
    const double s = off.dot(tools_[i].axis_w), clear = solid_.radius_mm + best.entry_mm;
    if (clear > 0 && off.squaredNorm() - s * s > clear * clear) continue;
    const std::optional<RayInterval> t = ray_through(solid_, tools_[i], ray.point_w_mm, ray.normal_w);
    if (!t || t->out_mm <= -depth_mm) continue;
    if (t->in_mm < best.entry_mm || (t->in_mm == best.entry_mm && i < best.position)) best = {t->in_mm, i};
  }
}

FirstEntry CutEnvelope::search(const SurfaceRay& ray, double depth_mm, std::size_t hint) const {
  FirstEntry best{kNowhere_mm, 0};
  search_leaf(hint, ray, depth_mm, best);
  struct Open {
    std::size_t node;
    double bound_mm;
  };
  std::array<Open, 128> stack;
  std::size_t open = 0;
  stack[open++] = {1, bound_mm(1, ray.point_w_mm)};
  while (open > 0) {
    const Open top = stack[--open];
    if (top.bound_mm > best.entry_mm) continue;
    if (top.node >= leaves_) {
      search_leaf(top.node - leaves_, ray, depth_mm, best);
      continue;
    }
    Open near{2 * top.node, bound_mm(2 * top.node, ray.point_w_mm)};
    Open far{2 * top.node + 1, bound_mm(2 * top.node + 1, ray.point_w_mm)};
    if (far.bound_mm < near.bound_mm) std::swap(near, far);
    if (far.bound_mm <= best.entry_mm) stack[open++] = far;
    if (near.bound_mm <= best.entry_mm) stack[open++] = near;
  }
  return best;
}

std::vector<FirstEntry> CutEnvelope::first_entries(std::span<const SurfaceRay> rays, double depth_mm,
                                                   unsigned threads) const {
  std::vector<FirstEntry> entries(rays.size());
  in_blocks(rays.size(), threads, [&](std::size_t first, std::size_t last) {
    std::size_t hint = 0;  // neighbouring rays are cut by neighbouring positions
    for (std::size_t i = first; i < last; ++i) {
      entries[i] = search(rays[i], depth_mm, hint);
      hint = entries[i].position / kLeaf;
    }
  });
  return entries;
}

}  // namespace trunnion
