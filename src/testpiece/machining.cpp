#include "testpiece/machining.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "error.h"
#include "testpiece/parallel.h"
#include "units/angle.h"

namespace trunnion {
namespace {

using Eigen::Vector3d;

[[noreturn]] void refuse_uncut(const TestPiece& piece, const ConePoint& on) {
  const Vector3d in_cone = w_from_cone(piece.cone).inverse(Eigen::Isometry) * on.point_w_mm;
  const double phi = std::atan2(in_cone.y(), in_cone.x()) * 360 / kTurn_rad;
  throw RangeError("the path never cuts the surface at phi " + std::to_string(phi < -1e-9 ? phi + 360 : phi) +
                   " deg, h " + std::to_string(in_cone.z()) + " mm");
}

/// What cuts each point first.
std::vector<FirstEntry> first_cuts(const TestPiece& piece, std::span<const ConePoint> points,
                                   std::vector<ToolInWorkpiece> tools, unsigned threads) {
  double reach = 0;
  for (const ToolInWorkpiece& tool : tools)
    reach = std::max(reach, (tool.tip_w_mm - piece.cone.base_center_w_mm).norm());
  reach += piece.cone.height.in_millimetres() + piece.cone.base_diameter.in_millimetres();
  // Not so deep that the far side of the piece counts.
  const double depth =
      0.5 * std::min(piece.tool.diameter.in_millimetres(), radius_at(piece.cone, piece.cone.height).in_millimetres());

  std::vector<SurfaceRay> rays;
  rays.reserve(points.size());
  for (const ConePoint& on : points) rays.push_back({on.point_w_mm, on.normal_w});
  const CutEnvelope envelope(std::move(tools), solid_of(piece.tool), reach);
  std::vector<FirstEntry> entries = envelope.first_entries(rays, depth, threads);
  for (std::size_t i = 0; i < entries.size(); ++i)
    if (!std::isfinite(entries[i].entry_mm)) refuse_uncut(piece, points[i]);
  return entries;
}

}  // namespace

SurfaceGrid evaluated_surface(const TestPiece& piece) {
  SurfaceGrid surface;
  const Eigen::Isometry3d frame = w_from_cone(piece.cone);
  for (int k = 0; k < piece.points; ++k) surface.phi_rad.push_back(kTurn_rad * k / piece.points);
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
    const double turns = path[i].phi_rad / kTurn_rad;
    const double station = (turns - std::floor(turns)) * static_cast<double>(n);
    const auto k = static_cast<std::size_t>(std::lround(station)) % n;
    if (std::abs(station - std::round(station)) * kTurn_rad > kSamePhi_rad * static_cast<double>(n)) continue;
    for (std::size_t j = 0; j < surface.h_mm.size(); ++j) {
      const ConePoint& on = surface.points[j * n + k];
      const Vector3d off = tools[i].tip_w_mm - on.point_w_mm;
      const Vector3d to_axis = off - off.dot(tools[i].axis_w) * tools[i].axis_w;
      deviation[j * n + k] = std::min(deviation[j * n + k], to_axis.dot(on.normal_w) - radius);
    }
  }
  for (std::size_t i = 0; i < deviation.size(); ++i)
    if (!std::isfinite(deviation[i])) refuse_uncut(piece, surface.points[i]);
  return deviation;
}

std::vector<double> envelope_deviation_mm(const TestPiece& piece, const SurfaceGrid& surface,
                                          std::vector<ToolInWorkpiece> tools, unsigned threads) {
  std::vector<double> deviation;
  for (const FirstEntry& first : first_cuts(piece, surface.points, std::move(tools), threads))
    deviation.push_back(first.entry_mm);
  return deviation;
}

std::vector<CutPoint> cut_points(const TestPiece& piece, std::span<const ConePoint> points,
                                 std::span<const ToolPosition> path, const KinematicChain& chain, unsigned threads) {
  const std::vector<FirstEntry> first =
      first_cuts(piece, points, actual_tools(path, chain, Model{}, piece.tool.length, {}, threads), threads);
  std::vector<CutPoint> cut;
  cut.reserve(first.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    const Eigen::Isometry3d r_from_w = chain.r_from_w(path[first[i].position].at);
    CutPoint point{first[i].position, first[i].entry_mm, r_from_w * points[i].point_w_mm,
                   r_from_w.linear() * points[i].normal_w};
    point.by_error << -point.normal_r, -point.point_r_mm.cross(point.normal_r);
    cut.push_back(point);
  }
  return cut;
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
