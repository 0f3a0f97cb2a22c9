#include "io/piece_observations.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "error.h"

namespace trunnion {
namespace {

constexpr double kLeastSigma_mm = 1e-6;

std::optional<std::size_t> column(const MeasuredPiece& measured, const std::string& name) {
  const auto found = std::ranges::find(measured.columns, name);
  if (found == measured.columns.end()) return std::nullopt;
  return static_cast<std::size_t>(found - measured.columns.begin());
}

/// Rows in the order of the cut: by position, then from the base up.
std::vector<std::size_t> order_of_cut(const MeasuredPiece& measured, const std::vector<CutPoint>& cut) {
  std::vector<std::size_t> order(cut.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return std::pair(cut[i].position, measured.points[i].h); });
  return order;
}

}  // namespace

PieceObservations observations_of(const PieceReading& in) {
  const MeasuredPiece& measured = in.measured;
  const Eigen::Isometry3d frame = w_from_cone(in.piece.cone);
  std::vector<ConePoint> points;
  for (const MeasuredPoint& p : measured.points) points.push_back(cone_point(in.piece.cone, frame, p.phi, p.h));
  const std::vector<CutPoint> cut = cut_points(in.piece, points, in.path, in.chain);
  const std::vector<bool> steady = cut_steadily(in.piece, cut, in.path);

  PieceObservations out;
  out.sigma_told = measured.points.front().sigma_mm > 0;
  const double found_sigma = out.sigma_told ? 0 : point_to_point_sigma_mm(traces_of(measured, in.piece));
  if (!out.sigma_told && found_sigma <= 0)
    throw InputError(measured.file, "no noise from point to point; a column sigma_um is wanted");

  const std::optional<std::size_t> time = column(measured, "time_s"), temperature = column(measured, "temperature_C");
  ObservationSet& set = out.set;
  set.files = {measured.file};
  set.has_time = time.has_value() || in.piece.feed_mm_per_min.has_value();
  set.has_temperature = temperature.has_value() || in.known.temperature_C != Situation{}.temperature_C;
  set.has_tilt_sense = set.has_turn_sense = set.has_sigma = true;
  std::vector<std::size_t> extra;
  for (std::size_t k = 0; k < measured.columns.size(); ++k) {
    if (k == time || k == temperature) continue;
    extra.push_back(k);
    set.extra_columns.push_back(measured.columns[k]);
  }
  std::vector<double> of_job;  // covariates that are the same for all points
  for (std::size_t k = 0; in.known.extra.names != nullptr && k < in.known.extra.names->size(); ++k) {
    const std::string& name = (*in.known.extra.names)[k];
    if (name == "time_s" || name == "temperature_C" || column(measured, name)) continue;
    of_job.push_back(in.known.extra.values[k]);
    set.extra_columns.push_back(name);
  }

  double squares = 0;
  for (const std::size_t i : order_of_cut(measured, cut)) {
    if (!steady[i]) {
      ++out.unsteady;
      continue;
    }
    const MeasuredPoint& point = measured.points[i];
    const double* values = measured.values.data() + i * measured.columns.size();
    const Situation s = situation_at(in.path[cut[i].position], in.piece.tool.length, in.known);
    Observation row{.kind = ReadingKind::surface, .line = point.line, .at = s.at};
    row.position_mm = cut[i].point_r_mm;
    row.direction = -cut[i].normal_r;
    row.value = point.deviation_mm - cut[i].commanded_mm;
    row.time_s = time ? values[*time] : s.time_s;
    row.temperature_C = temperature ? values[*temperature] : s.temperature_C;
    row.tilt_sense = s.tilt_sense;
    row.turn_sense = s.turn_sense;
    row.sigma = std::max(kLeastSigma_mm, out.sigma_told ? point.sigma_mm : found_sigma);
    row.cut = static_cast<std::uint32_t>(set.cuts.size());
    const double turn = point.phi.in_radians() / (2 * std::numbers::pi);
    set.cuts.push_back({.tip_r_mm = s.point_r_mm,
                        .linear_sense = s.linear_sense,
                        .tool_length_mm = s.tool_length_mm,
                        .stretch = static_cast<std::uint32_t>((turn - std::floor(turn)) * in.stretches)});
    for (const std::size_t k : extra) set.extra_values.push_back(values[k]);
    set.extra_values.insert(set.extra_values.end(), of_job.begin(), of_job.end());
    squares += row.sigma * row.sigma;
    set.rows.push_back(row);
    out.point_of_row.push_back(i);
  }
  if (set.rows.empty())
    throw InputError(measured.file, "no point was cut in steady motion; a denser or other path is wanted");
  out.sigma_mm = std::sqrt(squares / static_cast<double>(set.rows.size()));
  return out;
}

}  // namespace trunnion
