#include "testpiece/measured_piece.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "units/angle.h"

namespace trunnion {
namespace {

constexpr double kLargestStep_mm = 0.02;  ///< that an effect may leave at a reversal: how wide the contact is there

/// What has to stay the same along a steady cut.
bool same_motion(const ToolPosition& a, const ToolPosition& b) {
  return a.tilt_sense == b.tilt_sense && a.turn_sense == b.turn_sense && a.linear_sense == b.linear_sense;
}

}  // namespace

std::vector<ConeTrace> traces_of(const MeasuredPiece& measured, const TestPiece& piece) {
  std::map<double, std::vector<const MeasuredPoint*>> heights;
  for (const MeasuredPoint& point : measured.points) heights[point.h.in_millimetres()].push_back(&point);
  std::vector<ConeTrace> traces;
  for (auto& [h, points] : heights) {
    std::ranges::stable_sort(points, {}, [](const MeasuredPoint* p) { return p->phi; });
    ConeTrace& trace = traces.emplace_back();
    trace.h_mm = h;
    trace.nominal_radius_mm = radius_at(piece.cone, Length::millimetres(h)).in_millimetres();
    for (const MeasuredPoint* p : points) {
      trace.phi_rad.push_back(p->phi.in_radians());
      trace.normal_mm.push_back(p->deviation_mm);
    }
  }
  return traces;
}

double point_to_point_sigma_mm(std::span<const ConeTrace> traces) {
  constexpr double kMedianToSigma = 1.4826;
  std::vector<double> differences;
  for (const ConeTrace& trace : traces) {
    const std::vector<double>& y = trace.normal_mm;
    if (y.size() < 5) continue;
    for (std::size_t i = 0; i < y.size(); ++i)
      differences.push_back(std::abs(y[i] - 2 * y[(i + 1) % y.size()] + y[(i + 2) % y.size()]));
  }
  if (differences.empty()) return 0;
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::ranges::nth_element(differences, middle);
  return kMedianToSigma * *middle / std::sqrt(6);
}

std::vector<bool> cut_steadily(const TestPiece& piece, std::span<const CutPoint> cut,
                               std::span<const ToolPosition> path) {
  const double tool = 0.5 * piece.tool.diameter.in_millimetres();
  const double radius = 0.5 * piece.cone.base_diameter.in_millimetres();
  const double reach = std::sqrt(2 * kLargestStep_mm * tool * radius / (tool + radius)) / radius;  // rad about the axis
  // Positions in the order of phi, once round and a little more, so that neighbours across 0 are neighbours.
  std::vector<std::pair<double, std::size_t>> by_phi;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const double phi = path[i].phi_rad - kTurn_rad * std::floor(path[i].phi_rad / kTurn_rad);
    by_phi.emplace_back(phi, i);
    if (phi < reach) by_phi.emplace_back(phi + kTurn_rad, i);
    if (phi > kTurn_rad - reach) by_phi.emplace_back(phi - kTurn_rad, i);
  }
  std::ranges::sort(by_phi);
  const double whole_s = path.empty() ? 0 : path.back().time_s - path.front().time_s;
  std::vector<bool> steady;
  for (const CutPoint& point : cut) {
    const ToolPosition& own = path[point.position];
    const double phi = own.phi_rad - kTurn_rad * std::floor(own.phi_rad / kTurn_rad);
    const auto from = std::ranges::lower_bound(by_phi, std::pair(phi - reach, std::size_t{0}));
    bool same = true;
    for (auto at = from; at != by_phi.end() && at->first <= phi + reach && same; ++at) {
      const ToolPosition& other = path[at->second];
      same = same_motion(own, other) && std::abs(other.time_s - own.time_s) <= 0.5 * whole_s;
    }
    steady.push_back(same);
  }
  return steady;
}

}  // namespace trunnion
