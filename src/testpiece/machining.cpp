#include "testpiece/machining.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "error.h"
#include "testpiece/parallel.h"

namespace trunnion {
namespace {

using Eigen::Vector3d;

constexpr double kTurn = 2 * std::numbers::pi;

[[noreturn]] void refuse_uncut(const SurfaceGrid& surface, std::size_t index) {
  const double phi = surface.phi_rad[index % surface.phi_rad.size()] * 360 / kTurn;
  const double h = surface.h_mm[index / surface.phi_rad.size()];
  throw RangeError("the path never cuts the surface at phi " + std::to_string(phi) + " deg, h " + std::to_string(h) +
                   " mm");
}

/// What cuts each evaluated point first.
std::vector<FirstEntry> first_cuts(const TestPiece& piece, const SurfaceGrid& surface,
                                   std::vector<ToolInWorkpiece> tools, unsigned threads) {
  double reach = 0;
  for (const ToolInWorkpiece& tool : tools)
    reach = std::max(reach, (tool.tip_w_mm - piece.cone.base_center_w_mm).norm());
  reach += piece.cone.height.in_millimetres() + piece.cone.base_diameter.in_millimetres();
  double depth = piece.tool.diameter.in_millimetres() / 2;
  for (const double h : surface.h_mm)
    depth = std::min(depth, radius_at(piece.cone, Length::millimetres(h)).in_millimetres() / 2);

  std::vector<SurfaceRay> rays;
  rays.reserve(surface.points.size());
  for (const ConePoint& on : surface.points) rays.push_back({on.point_w_mm, on.normal_w});
  const CutEnvelope envelope(std::move(tools), solid_of(piece.tool), reach);
  std::vector<FirstEntry> entries = envelope.first_entries(rays, depth, threads);
  for (std::size_t i = 0; i < entries.size(); ++i)
    if (!std::isfinite(entries[i].entry_mm)) refuse_uncut(surface, i);
  return entries;
}

}  // namespace

SurfaceGrid evaluated_surface(const TestPiece& piece) {
  SurfaceGrid surface;
  const Eigen::Isometry3d frame = w_from_cone(piece.cone);
  for (int k = 0; k < piece.points; ++k) surface.phi_rad.push_back(kTurn * k / piece.points);
  for (const Length h : piece.heights) {
    surface.h_mm.push_back(h.in_millimetres());
    for (const double phi : surface.phi_rad)
      surface.points.push_back(cone_point(piece.cone, frame, Angle::radians(phi), h));
  }
  return surface;
}

Situation situation_at(const ToolPosition& position, Length tool_length, const Situation& known) {
  Situation s = known;
  s.at = position.at;
  s.point_r_mm = position.tip_r_mm;
  s.linear_sense = position.linear_sense;
  s.tool_length_mm = tool_length.in_millimetres();
  s.tilt_sense = position.tilt_sense;
  s.turn_sense = position.turn_sense;
  s.time_s = known.time_s + position.time_s;
  return s;
}

std::vector<ToolInWorkpiece> actual_tools(std::span<const ToolPosition> path, const KinematicChain& chain,
                                          const Model& model, Length tool_length, const Situation& known,
                                          unsigned threads) {
  std::vector<ToolInWorkpiece> tools(path.size());
  in_blocks(path.size(), threads, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const ToolPosition& p = path[i];
      const PoseError e = relative_error(model, situation_at(p, tool_length, known));
      const Eigen::Isometry3d w_from_r = (transform(e) * chain.r_from_w(p.at)).inverse(Eigen::Isometry);
      tools[i] = {w_from_r * p.tip_r_mm,
                  (w_from_r.linear() * (chain.r_from_t(p.at).linear() * Vector3d::UnitZ())).normalized()};
    }
  });
  return tools;
}

std::vector<double> first_order_deviation_mm(const TestPiece& piece, const SurfaceGrid& surface,
                                             std::span<const ToolPosition> path,
                                             std::span<const ToolInWorkpiece> tools) {
  constexpr double kSamePhi_rad = 1e-9;
  const std::size_t n = surface.phi_rad.size();
  const double radius = 0.5 * piece.tool.diameter.in_millimetres();
  std::vector<double> deviation(surface.points.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < path.size(); ++i) {
    const double turns = path[i].phi_rad / kTurn;
    const double station = (turns - std::floor(turns)) * static_cast<double>(n);
    const auto k = static_cast<std::size_t>(std::lround(station)) % n;
    if (std::abs(station - std::round(station)) * kTurn > kSamePhi_rad * static_cast<double>(n)) continue;
    for (std::size_t j = 0; j < surface.h_mm.size(); ++j) {
      const ConePoint& on = surface.points[j * n + k];
      const Vector3d off = tools[i].tip_w_mm - on.point_w_mm;
      const Vector3d to_axis = off - off.dot(tools[i].axis_w) * tools[i].axis_w;
      deviation[j * n + k] = std::min(deviation[j * n + k], to_axis.dot(on.normal_w) - radius);
    }
  }
  for (std::size_t i = 0; i < deviation.size(); ++i)
    if (!std::isfinite(deviation[i])) refuse_uncut(surface, i);
  return deviation;
}

std::vector<double> envelope_deviation_mm(const TestPiece& piece, const SurfaceGrid& surface,
                                          std::vector<ToolInWorkpiece> tools, unsigned threads) {
  std::vector<double> deviation;
  for (const FirstEntry& first : first_cuts(piece, surface, std::move(tools), threads))
    deviation.push_back(first.entry_mm);
  return deviation;
}

std::vector<CutPoint> cut_points(const TestPiece& piece, const SurfaceGrid& surface, std::span<const ToolPosition> path,
                                 const KinematicChain& chain, unsigned threads) {
  std::vector<ToolInWorkpiece> tools;
  tools.reserve(path.size());
  for (const ToolPosition& p : path) tools.push_back(p.nominal);
  const std::vector<FirstEntry> first = first_cuts(piece, surface, std::move(tools), threads);
  std::vector<CutPoint> points;
  points.reserve(first.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    const Eigen::Isometry3d r_from_w = chain.r_from_w(path[first[i].position].at);
    CutPoint point{first[i].position, r_from_w * surface.points[i].point_w_mm,
                   r_from_w.linear() * surface.points[i].normal_w};
    point.by_error << -point.normal_r, -point.point_r_mm.cross(point.normal_r);
    points.push_back(point);
  }
  return points;
}

std::vector<ConeTrace> traces_of(const TestPiece& piece, const SurfaceGrid& surface,
                                 std::span<const double> deviation_mm) {
  const std::size_t n = surface.phi_rad.size();
  std::vector<ConeTrace> traces;
  for (std::size_t j = 0; j < surface.h_mm.size(); ++j) {
    const std::span<const double> part = deviation_mm.subspan(j * n, n);
    traces.push_back({.h_mm = surface.h_mm[j],
                      .nominal_radius_mm = radius_at(piece.cone, Length::millimetres(surface.h_mm[j])).in_millimetres(),
                      .phi_rad = surface.phi_rad,
                      .normal_mm = {part.begin(), part.end()}});
  }
  return traces;
}

}  // namespace trunnion
