#include "planning/probing_plan.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

#include "error.h"
#include "geometric_errors/pose_error.h"

namespace trunnion {
namespace {

constexpr double kGrazing = -0.05;  // of the outward normal along the tool's axis: a side of a column as it stands
constexpr double kLever_mm = 100;
constexpr double kRetract_mm = 30;  // that the probe stands off a face before and after
constexpr double kPassing_mm = 5;  // that the ball keeps from what it passes by, with all that comes down beside a face

/// What an artifact takes up, as far as its spots tell: their box, and all below it down to the table.
std::map<std::string, Eigen::AlignedBox3d> boxes_of(const std::vector<Spot>& spots) {
  std::map<std::string, Eigen::AlignedBox3d> boxes;
  for (const Spot& spot : spots) {
    boxes[spot.artifact].extend(spot.place_w_mm);
    boxes[spot.artifact].extend(Eigen::Vector3d(spot.place_w_mm.x(), spot.place_w_mm.y(), -1e4));
  }
  return boxes;
}

/// Whether the half line from `from` along `along` meets the box.
bool meets(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& from, const Eigen::Vector3d& along) {
  double enter = 0, leave = 1e4;
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (std::abs(along[i]) < 1e-12) {
      if (from[i] < box.min()[i] || from[i] > box.max()[i]) return false;
      continue;
    }
    const double a = (box.min()[i] - from[i]) / along[i], b = (box.max()[i] - from[i]) / along[i];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave;
}

Vector6d functional(const Spot& spot, const Eigen::Isometry3d& r_from_w) {
  const Eigen::Vector3d n = -(r_from_w.linear() * spot.outward_w), p = r_from_w * spot.place_w_mm;
  Vector6d g;
  g << n, p.cross(n) / kLever_mm;
  return g;
}

double log_det(const std::vector<Vector6d>& g, const std::vector<std::size_t>& chosen) {
  Matrix6d m = 1e-6 * Matrix6d::Identity();
  for (const std::size_t k : chosen) m += g[k] * g[k].transpose();
  return std::log(m.determinant());
}

int sense_of(Angle from, Angle to, int before) {
  const double turned = (to - from).in_degrees();
  return std::abs(turned) < 1e-9 ? before : (turned > 0 ? 1 : -1);
}

}  // namespace

std::vector<Spot> column_spots() {
  constexpr double kOut = 90, kHalf = 20, kSide_z = 100, kTop_z = 110;
  std::vector<Spot> spots;
  int column = 0;
  for (const Eigen::Vector2d& centre : {Eigen::Vector2d(-kOut, -kOut), {kOut, -kOut}, {-kOut, kOut}}) {
    const std::string artifact = std::to_string(++column);
    int number = 0;
    for (const Eigen::Vector3d& outward : {Eigen::Vector3d(1, 0, 0), {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}})
      spots.push_back({artifact + "S" + std::to_string(++number), artifact,
                       Eigen::Vector3d(centre.x(), centre.y(), kSide_z) + kHalf * outward, outward});
    number = 0;
    for (const double off : {-12.0, 12.0})
      spots.push_back({artifact + "T" + std::to_string(++number), artifact,
                       Eigen::Vector3d(centre.x() + off, centre.y() + off, kTop_z), Eigen::Vector3d::UnitZ()});
  }
  return spots;
}

std::vector<Spot> spots_of(const ObservationSet& observations, const KinematicChain& chain) {
  std::map<std::uint32_t, std::pair<Spot, double>> sums;
  for (const Observation& o : observations.rows) {
    if (o.kind != ReadingKind::contact) continue;
    auto& [spot, count] = sums[o.point];
    spot.point = observations.points[o.point];
    spot.artifact = observations.artifacts.empty() ? "" : observations.artifacts[o.artifact];
    const Eigen::Isometry3d w_from_r = chain.r_from_w(o.at).inverse();
    spot.place_w_mm += w_from_r * o.position_mm;
    spot.outward_w -= w_from_r.linear() * o.direction;
    ++count;
  }
  std::vector<Spot> spots;
  for (auto& [index, sum] : sums) {
    spots.push_back(std::move(sum.first));
    spots.back().place_w_mm /= sum.second;
    spots.back().outward_w.normalize();
  }
  return spots;
}

Range<Angle> planned_tilts(const Machine& machine, const PlanOptions& options) {
  Range<Angle> range{Angle::degrees(-90), Angle()};
  if (machine.work_volume.a) range = *machine.work_volume.a;
  if (options.tilt_low < options.tilt_high) range = {options.tilt_low, options.tilt_high};
  if (const auto& stroke = machine.tilt().range_angle)
    range = {std::max(range.low, stroke->low), std::min(range.high, stroke->high)};
  if (!(range.low < range.high))
    throw RangeError(std::string("plan: no tilt of ") + machine.tilt_letter() + " lies within its stroke");
  return range;
}

std::vector<std::size_t> reachable(const Machine& machine, const KinematicChain& chain, const std::vector<Spot>& spots,
                                   IndexedPosition at) {
  const Eigen::Isometry3d r_from_w = chain.r_from_w(at);
  const Eigen::Vector3d tool = chain.r_from_t(at).linear() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d tool_w = r_from_w.linear().transpose() * tool;
  const double radius_mm = machine.probe.ball_radius.in_millimetres();
  const auto boxes = boxes_of(spots);
  // The probe comes down along the tool's axis, and its stylus stands there: nothing else may.
  const auto free = [&](const Spot& spot) {
    for (const auto& [artifact, box] : boxes) {
      if (artifact == spot.artifact) continue;
      const Eigen::Vector3d margin = Eigen::Vector3d::Constant(radius_mm + kPassing_mm);
      const Eigen::AlignedBox3d kept(box.min() - margin, box.max() + margin);
      for (const double off : {radius_mm, radius_mm + kLargestStandoff_mm})
        if (meets(kept, spot.place_w_mm + off * spot.outward_w, tool_w)) return false;
    }
    return true;
  };
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < spots.size(); ++k) {
    const Eigen::Vector3d outward = r_from_w.linear() * spots[k].outward_w;
    if (outward.dot(tool) < kGrazing || !free(spots[k])) continue;
    bool within = true;
    for (const double off : {0.0, kRetract_mm}) {
      const Eigen::Vector3d place = r_from_w * spots[k].place_w_mm + off * outward;
      for (Eigen::Index i = 0; i < 3; ++i)
        if (const auto& stroke = machine.axes.at("XYZ"[i]).range_length)
          within = within && place[i] >= stroke->low.in_millimetres() && place[i] <= stroke->high.in_millimetres();
    }
    if (within) found.push_back(k);
  }
  return found;
}

std::vector<std::size_t> best_spots(const Machine& machine, const KinematicChain& chain, const std::vector<Spot>& spots,
                                    IndexedPosition at, std::size_t count) {
  std::vector<std::size_t> within = reachable(machine, chain, spots, at);
  if (within.size() <= count) return within;
  const Eigen::Isometry3d r_from_w = chain.r_from_w(at);
  std::vector<Vector6d> g;
  for (const Spot& spot : spots) g.push_back(functional(spot, r_from_w));
  std::vector<std::size_t> chosen(within.begin(), within.begin() + static_cast<std::ptrdiff_t>(count));
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t& out : chosen)
      for (const std::size_t in : within) {
        if (std::ranges::find(chosen, in) != chosen.end()) continue;
        std::vector<std::size_t> tried = chosen;
        tried[static_cast<std::size_t>(&out - chosen.data())] = in;
        if (log_det(g, tried) > log_det(g, chosen) + 1e-9) out = in, changed = true;
      }
  }
  std::ranges::sort(chosen);
  return chosen;
}

std::vector<Visit> first_plan(const Machine& machine, const std::vector<Spot>& spots, const PlanOptions& options) {
  constexpr int kTilts = 4, kTurns = 6;
  const KinematicChain chain(machine);
  const Range<Angle> tilts = planned_tilts(machine, options);
  const auto visit = [&](Angle a, Angle c, int repeat) {
    return Visit{.at = {a, c}, .spots = best_spots(machine, chain, spots, {a, c}, options.touches), .repeat = repeat};
  };
  const auto reference = [&](int repeat) {
    return Visit{.at = {}, .spots = reachable(machine, chain, spots, {}), .repeat = repeat};
  };
  // The tilts go from the reference pose outwards, or from one end to the other where it is not among them.
  const bool from_top = std::abs(tilts.high.in_degrees()) <= std::abs(tilts.low.in_degrees());
  std::vector<Visit> pass;
  for (int i = 0; i < kTilts; ++i)
    for (int j = 0; j < kTurns; ++j) {
      const double share = i / (kTilts - 1.0);
      const Angle a =
          from_top ? tilts.high + share * (tilts.low - tilts.high) : tilts.low + share * (tilts.high - tilts.low);
      const Angle c = Angle::degrees(360.0 * j / kTurns);
      if (std::abs(a.in_degrees()) > 1e-9 || j > 0) pass.push_back(visit(a, c, 0));
    }
  std::vector<Visit> plan = {reference(0)};
  plan.insert(plan.end(), pass.begin(), pass.end());
  plan.push_back(reference(1));
  // The second pass comes to each position from the other side of both axes.
  int tilt_sense = 1, turn_sense = 1;
  IndexedPosition before;
  for (Visit& v : pass) {
    tilt_sense = sense_of(before.a, v.at.a, tilt_sense);
    turn_sense = sense_of(before.c, v.at.c, turn_sense);
    before = v.at;
    v.tilt_sense = -tilt_sense, v.turn_sense = -turn_sense;
    v.repeat = 1;
    std::ranges::reverse(v.spots);
  }
  plan.insert(plan.end(), pass.rbegin(), pass.rend());
  // Off the grid in both angles, and in no order.
  for (const auto& [share, turn] : {std::pair(0.45, 97.0), {0.12, 223.0}, {0.85, 341.0}, {0.62, 158.0}})
    plan.push_back(visit(tilts.high + share * (tilts.low - tilts.high), Angle::degrees(turn), 1));
  plan.push_back(reference(1));
  std::erase_if(plan, [](const Visit& v) { return v.spots.empty(); });
  return plan;
}

ObservationSet planned_observations(const Machine& machine, const std::vector<Spot>& spots,
                                    const std::vector<Visit>& visits, const PlanOptions& options,
                                    const std::string& name) {
  const KinematicChain chain(machine);
  ObservationSet set{.files = {name}};
  std::map<std::string, std::uint32_t> artifacts;
  std::vector<std::uint32_t> artifact_of;
  for (const Spot& spot : spots) {
    set.points.push_back(spot.point);
    const auto [entry, added] = artifacts.emplace(spot.artifact, static_cast<std::uint32_t>(set.artifacts.size()));
    if (added) set.artifacts.push_back(spot.artifact);
    artifact_of.push_back(entry->second);
  }
  set.has_time = set.has_tilt_sense = set.has_turn_sense = set.has_repeat = true;
  double time_s = options.start_s;
  int tilt_sense = 1, turn_sense = 1;
  IndexedPosition before;
  for (const Visit& visit : visits) {
    time_s += options.pose_s;
    tilt_sense = visit.tilt_sense != 0 ? visit.tilt_sense : sense_of(before.a, visit.at.a, tilt_sense);
    turn_sense = visit.turn_sense != 0 ? visit.turn_sense : sense_of(before.c, visit.at.c, turn_sense);
    before = visit.at;
    const Eigen::Isometry3d r_from_w = chain.r_from_w(visit.at);
    for (const std::size_t k : visit.spots) {
      time_s += options.touch_s;
      Observation o{.line = static_cast<std::uint32_t>(set.rows.size() + 2),
                    .at = visit.at,
                    .point = static_cast<std::uint32_t>(k),
                    .artifact = artifact_of[k]};
      o.position_mm = r_from_w * spots[k].place_w_mm;
      o.direction = -(r_from_w.linear() * spots[k].outward_w);
      o.repeat = visit.repeat;
      o.time_s = time_s;
      o.tilt_sense = tilt_sense;
      o.turn_sense = turn_sense;
      set.rows.push_back(o);
    }
  }
  return set;
}

}  // namespace trunnion
