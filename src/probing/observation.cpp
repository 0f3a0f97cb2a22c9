#include "probing/observation.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <unordered_map>

#include "error.h"

namespace trunnion {
namespace {

constexpr Angle kSamePose = Angle::degrees(0.1);

double turn_remainder(double radians) { return std::remainder(radians, 2 * std::numbers::pi); }

std::vector<std::uint32_t> merge_labels(std::vector<std::string>& into, const std::vector<std::string>& labels) {
  std::unordered_map<std::string, std::uint32_t> known;
  for (std::uint32_t i = 0; i < into.size(); ++i) known.emplace(into[i], i);
  std::vector<std::uint32_t> map;
  for (const std::string& label : labels) {
    const auto [entry, added] = known.emplace(label, static_cast<std::uint32_t>(into.size()));
    if (added) into.push_back(label);
    map.push_back(entry->second);
  }
  return map;
}

std::vector<PoseGroup> standing_groups(const ObservationSet& set) {
  // Cells of the tolerance's size; a row joins the first group within the tolerance in its own or a neighbouring cell.
  constexpr double kCell = Angle::degrees(0.1).in_radians();
  const auto cells_per_turn = static_cast<long>(std::floor(2 * std::numbers::pi / kCell));
  std::map<std::pair<long, long>, std::vector<std::size_t>> cells;
  std::vector<PoseGroup> groups;
  std::vector<IndexedPosition> first;
  std::vector<std::pair<double, double>> sums;  // of differences to the first row
  const double tolerance = kSamePose.in_radians() * (1 + 1e-9);
  for (std::size_t r = 0; r < set.rows.size(); ++r) {
    if (set.rows[r].kind == ReadingKind::surface) continue;
    const IndexedPosition at = set.rows[r].at;
    const double turned =
        at.c.in_radians() - 2 * std::numbers::pi * std::floor(at.c.in_radians() / (2 * std::numbers::pi));
    const long ka = std::lround(std::floor(at.a.in_radians() / kCell)), kc = std::lround(std::floor(turned / kCell));
    std::size_t found = groups.size();
    for (long da = -1; da <= 1 && found == groups.size(); ++da)
      for (long dc = -2; dc <= 2 && found == groups.size(); ++dc) {
        const auto cell = cells.find({ka + da, ((kc + dc) % cells_per_turn + cells_per_turn) % cells_per_turn});
        if (cell == cells.end()) continue;
        for (const std::size_t g : cell->second)
          if (std::abs((at.a - first[g].a).in_radians()) <= tolerance &&
              std::abs(turn_remainder((at.c - first[g].c).in_radians())) <= tolerance) {
            found = g;
            break;
          }
      }
    if (found == groups.size()) {
      groups.push_back({.at = {at.a, Angle::radians(turned)}});
      first.push_back(at);
      sums.emplace_back(0, 0);
      cells[{ka, kc % cells_per_turn}].push_back(found);
    }
    groups[found].rows.push_back(r);
    sums[found].first += (at.a - first[found].a).in_radians();
    sums[found].second += turn_remainder((at.c - first[found].c).in_radians());
  }
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const double n = static_cast<double>(groups[g].rows.size());
    groups[g].at.a = first[g].a + Angle::radians(sums[g].first / n);
    groups[g].at.c = groups[g].at.c + Angle::radians(sums[g].second / n);
    groups[g].reference = std::abs(first[g].a.in_radians()) <= tolerance &&
                          std::abs(turn_remainder(first[g].c.in_radians())) <= tolerance;
  }
  return groups;
}

/// The stretches of measured pieces.
std::vector<PoseGroup> moving_groups(const ObservationSet& set) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> known;
  std::vector<PoseGroup> groups;
  for (std::size_t r = 0; r < set.rows.size(); ++r) {
    const Observation& row = set.rows[r];
    if (row.kind != ReadingKind::surface) continue;
    const auto [entry, added] = known.emplace(std::pair(row.artifact, set.cuts[row.cut].stretch), groups.size());
    if (added) groups.push_back({.moving = true});
    groups[entry->second].rows.push_back(r);
  }
  for (PoseGroup& group : groups) {
    const auto n = static_cast<double>(group.rows.size());
    double a = 0, c = 0;
    for (const std::size_t r : group.rows) {
      a += set.rows[r].at.a.in_radians() / n;
      c += set.rows[r].at.c.in_radians() / n;  // unwrapped along the path
    }
    group.at = {Angle::radians(a), Angle::radians(c - 2 * std::numbers::pi * std::floor(c / (2 * std::numbers::pi)))};
  }
  return groups;
}

}  // namespace

std::string ObservationSet::place(std::size_t row) const {
  const std::string& file = files.at(file_of_row.empty() ? 0 : file_of_row[row]);
  return file + ":" + std::to_string(rows[row].line);
}

ObservationSet joined(const ObservationSet& first, const ObservationSet& second) {
  if (first.has_time != second.has_time)
    throw InputError((first.has_time ? second : first).files.front(),
                     "time_s is missing, but the other file has it; both must run on one clock");
  ObservationSet set = first;
  if (set.file_of_row.empty()) set.file_of_row.assign(set.rows.size(), 0);
  const auto points = merge_labels(set.points, second.points),
             artifacts = merge_labels(set.artifacts, second.artifacts);
  const auto file_base = static_cast<std::uint32_t>(set.files.size());
  set.files.insert(set.files.end(), second.files.begin(), second.files.end());
  for (std::size_t r = 0; r < second.rows.size(); ++r) {
    Observation row = second.rows[r];
    row.point = points.empty() ? 0 : points[row.point];
    row.artifact = artifacts.empty() ? 0 : artifacts[row.artifact];
    row.cut += static_cast<std::uint32_t>(first.cuts.size());
    set.rows.push_back(row);
    set.file_of_row.push_back(file_base + (second.file_of_row.empty() ? 0 : second.file_of_row[r]));
  }
  set.cuts.insert(set.cuts.end(), second.cuts.begin(), second.cuts.end());
  for (bool ObservationSet::*flag : {&ObservationSet::has_temperature, &ObservationSet::has_tilt_sense,
                                     &ObservationSet::has_turn_sense, &ObservationSet::has_repeat})
    set.*flag = first.*flag && second.*flag;
  set.has_sigma = first.has_sigma || second.has_sigma;
  // Extra columns that both carry, in the first's order.
  set.extra_columns.clear();
  std::vector<std::pair<std::size_t, std::size_t>> columns;
  for (std::size_t i = 0; i < first.extra_columns.size(); ++i) {
    const auto other = std::ranges::find(second.extra_columns, first.extra_columns[i]);
    if (other == second.extra_columns.end()) continue;
    set.extra_columns.push_back(first.extra_columns[i]);
    columns.emplace_back(i, static_cast<std::size_t>(other - second.extra_columns.begin()));
  }
  set.extra_values.clear();
  for (std::size_t r = 0; r < first.rows.size(); ++r)
    for (const auto& [i, j] : columns)
      set.extra_values.push_back(first.extra_values[r * first.extra_columns.size() + i]);
  for (std::size_t r = 0; r < second.rows.size(); ++r)
    for (const auto& [i, j] : columns)
      set.extra_values.push_back(second.extra_values[r * second.extra_columns.size() + j]);
  return set;
}

ObservationSet joined_with_piece(const ObservationSet& readings, const ObservationSet& piece) {
  const auto completed = [](ObservationSet set, const ObservationSet& other) {
    std::vector<std::string> columns = set.extra_columns;
    for (const std::string& column : other.extra_columns)
      if (std::ranges::find(columns, column) == columns.end()) columns.push_back(column);
    std::vector<double> values(set.rows.size() * columns.size(), 0);
    for (std::size_t r = 0; r < set.rows.size(); ++r)
      std::copy_n(set.extra_values.begin() + static_cast<std::ptrdiff_t>(r * set.extra_columns.size()),
                  set.extra_columns.size(), values.begin() + static_cast<std::ptrdiff_t>(r * columns.size()));
    set.extra_columns = std::move(columns);
    set.extra_values = std::move(values);
    set.has_time = set.has_time || other.has_time;
    set.has_temperature = set.has_temperature || other.has_temperature;
    set.has_tilt_sense = set.has_tilt_sense || other.has_tilt_sense;
    set.has_turn_sense = set.has_turn_sense || other.has_turn_sense;
    set.has_repeat = set.has_repeat || other.has_repeat;
    return set;
  };
  return joined(completed(readings, piece), completed(piece, readings));
}

std::vector<Situation> situations(const ObservationSet& set) {
  std::vector<Situation> result;
  result.reserve(set.rows.size());
  double in_pose = 0;
  for (std::size_t r = 0; r < set.rows.size(); ++r) {
    const Observation& row = set.rows[r];
    if (r > 0) {
      const IndexedPosition before = set.rows[r - 1].at;
      const bool moved = std::abs((row.at.a - before.a).in_radians()) > kSamePose.in_radians() ||
                         std::abs((row.at.c - before.c).in_radians()) > kSamePose.in_radians() ||
                         row.repeat != set.rows[r - 1].repeat;
      in_pose = moved ? 0 : in_pose + 1;
    }
    Situation s;
    s.at = row.at;
    s.point_r_mm = row.kind == ReadingKind::pose || row.kind == ReadingKind::rotation ? Eigen::Vector3d::Zero().eval()
                                                                                      : row.position_mm;
    if (row.kind == ReadingKind::contact || row.kind == ReadingKind::displacement) s.approach_r = row.direction;
    if (row.kind == ReadingKind::contact)
      s.linear_sense =
          row.direction.unaryExpr([](double n) { return std::abs(n) < 1e-3 ? 0.0 : (n > 0 ? 1.0 : -1.0); });
    s.tilt_sense = row.tilt_sense;
    s.turn_sense = row.turn_sense;
    s.time_s = row.time_s;
    s.temperature_C = row.temperature_C;
    s.repeat = row.repeat;
    s.order = static_cast<double>(r);
    s.order_in_pose = in_pose;
    if (!set.points.empty()) s.point = set.points[row.point];
    if (!set.artifacts.empty()) s.artifact = set.artifacts[row.artifact];
    s.reading = row.kind;
    if (row.kind == ReadingKind::surface) {
      const CutMoment& cut = set.cuts[row.cut];
      s.point_r_mm = cut.tip_r_mm;
      s.linear_sense = cut.linear_sense;
      s.tool_length_mm = cut.tool_length_mm;
      s.reading = ReadingKind::none;
    }
    if (!set.extra_columns.empty())
      s.extra = {&set.extra_columns, set.extra_values.data() + r * set.extra_columns.size()};
    result.push_back(s);
  }
  return result;
}

std::vector<PoseGroup> pose_groups(const ObservationSet& set) {
  std::vector<PoseGroup> groups = standing_groups(set);
  for (PoseGroup& group : moving_groups(set)) groups.push_back(std::move(group));
  return groups;
}

}  // namespace trunnion
