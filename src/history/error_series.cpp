#include "history/error_series.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "error.h"
#include "errormap/pose_split.h"
#include "geometric_errors/symbol.h"
#include "identification/whitening.h"
#include "model/effects/location_errors.h"
#include "model/effects/rotary_error_map.h"

namespace trunnion {
namespace {

constexpr std::size_t kMostTilts = 5, kMostTurns = 8;
constexpr Angle kSameStation = Angle::degrees(0.1);

/// At most `most` of the stations, the first and the last among them.
std::vector<Angle> thinned(const std::vector<Angle>& stations, std::size_t most) {
  if (stations.size() <= most) return stations;
  std::vector<Angle> kept;
  for (std::size_t k = 0; k < most; ++k) kept.push_back(stations[k * (stations.size() - 1) / (most - 1)]);
  return kept;
}

bool same_station(Angle a, Angle b) {
  return std::abs(std::remainder((a - b).in_radians(), kFullTurn.in_radians())) <= kSameStation.in_radians();
}

bool stands_in(const std::vector<Angle>& stations, Angle angle) {
  return std::ranges::any_of(stations, [&](Angle station) { return same_station(station, angle); });
}

Situation at_position(IndexedPosition at) {
  Situation s;
  s.at = at;
  return s;
}

bool usable(const Model& model) {
  const RotaryErrorMap* map = model.rotary_map();
  return map != nullptr && map->has_uncertainty() && map->moves_table();
}

/// Whether every effect that moves the table can be asked at `at`.
bool known_at(const Model& model, IndexedPosition at) try {
  for (const EffectPtr& effect : model.effects)
    if (effect->moves_table() && effect->is_compensated()) effect->at(at_position(at));
  return model.rotary_map()->surface().covers(at.a);
} catch (const RangeError&) {
  return false;
}

/// The positions at which all are compared, by tilt; a tilt needs two turns.
std::vector<std::vector<SplitNode>> common_nodes(const std::vector<const Model*>& models) {
  const ErrorGrid& last = models.back()->rotary_map()->content().grid;
  std::vector<std::vector<SplitNode>> rows;
  for (const Angle a : thinned(last.a_stations, kMostTilts)) {
    std::vector<SplitNode> row;
    for (const Angle c : thinned(last.c_stations, kMostTurns))
      if (std::ranges::all_of(models, [&](const Model* model) { return known_at(*model, {a, c}); }))
        row.push_back({{a, c}});
    if (row.size() > 1) rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<IndexedPosition> positions(const std::vector<std::vector<SplitNode>>& rows) {
  std::vector<IndexedPosition> all;
  for (const std::vector<SplitNode>& row : rows)
    for (const SplitNode& node : row) all.push_back(node.at);
  return all;
}

/// The map as it was found at its nodes, unsmoothed, if all of `at` are among them; else nothing.
EffectPtr as_found(const RotaryErrorMap& map, const std::vector<IndexedPosition>& at, const EffectContext& context) {
  const RotaryMapContent& found = map.content();
  if (!found.full_covariance) return nullptr;
  for (const IndexedPosition& position : at)
    if (!stands_in(found.grid.a_stations, position.a) || !stands_in(found.grid.c_stations, position.c)) return nullptr;
  if (!stands_in(found.grid.a_stations, Angle()) || !stands_in(found.grid.c_stations, Angle())) return nullptr;
  RotaryMapContent nodes{.grid = found.grid, .grid_covariance = found.grid_covariance, .full_covariance = true};
  return std::make_shared<RotaryErrorMap>(std::move(nodes), context);
}

struct Stacked {
  Eigen::VectorXd delta;  ///< Dx … Dc of each position in turn
  Eigen::MatrixXd covariance;
};

Stacked stacked_pose_errors(const Model& model, const std::vector<IndexedPosition>& at, const EffectContext& context) {
  const auto n = 6 * static_cast<Eigen::Index>(at.size());
  Stacked stacked{.delta = Eigen::VectorXd::Zero(n), .covariance = Eigen::MatrixXd::Zero(n, n)};
  for (EffectPtr effect : model.effects) {
    if (!effect->is_compensated() || !effect->moves_table()) continue;
    double sigma_mm = 0, sigma_rad = 0;
    if (const auto* map = dynamic_cast<const RotaryErrorMap*>(effect.get())) {
      if (const EffectPtr nodes = as_found(*map, at, context)) {
        effect = nodes;
      } else {
        sigma_mm = map->content().interpolation_sigma_mm;
        sigma_rad = map->content().interpolation_sigma_rad;
      }
    }
    const auto m = static_cast<Eigen::Index>(effect->covariance().rows());
    Eigen::MatrixXd basis(n, m);
    for (std::size_t k = 0; k < at.size(); ++k) {
      const auto row = 6 * static_cast<Eigen::Index>(k);
      stacked.delta.segment<6>(row) += effect->at(at_position(at[k])).vector();
      if (m > 0) basis.middleRows<6>(row) = effect->basis(at_position(at[k]));
      stacked.covariance.diagonal().segment<3>(row).array() += sigma_mm * sigma_mm;
      stacked.covariance.diagonal().segment<3>(row + 3).array() += sigma_rad * sigma_rad;
    }
    if (m > 0) stacked.covariance += basis * effect->covariance() * basis.transpose();
  }
  return stacked;
}

/// The functions as linear maps from stacked pose errors, and back: what a free change of one does to them.
std::vector<ChangeMode> functions_of(const KinematicChain& chain, char tilt_letter,
                                     const std::vector<std::vector<SplitNode>>& rows) {
  const std::vector<IndexedPosition> at = positions(rows);
  const auto n = static_cast<Eigen::Index>(at.size());
  const auto every_sixth = [](const Eigen::MatrixXd& all, Eigen::Index first) {
    Eigen::MatrixXd some(all.rows() / 6, all.cols());
    for (Eigen::Index k = 0; k < some.rows(); ++k) some.row(k) = all.row(6 * k + first);
    return some;
  };
  std::vector<ChangeMode> functions;
  if (chain.has_rotary(Side::tool)) {
    const Eigen::MatrixXd same = Eigen::MatrixXd::Identity(6 * n, 6 * n);
    const std::vector<std::string> names = {"Dx", "Dy", "Dz", "Da", "Db", "Dc"};
    for (std::size_t c = 0; c < 6; ++c) {
      const Eigen::MatrixXd rows_of_c = every_sixth(same, static_cast<Eigen::Index>(c));
      functions.push_back({names[c], component_unit(c), at, rows_of_c.transpose(), rows_of_c});
    }
    return functions;
  }
  const PoseSplit split = split_pose_errors(chain, rows);
  std::vector<IndexedPosition> tilts;
  for (const std::vector<SplitNode>& row : rows) tilts.push_back({row.front().at.a, Angle()});
  for (const bool turn : {false, true})
    for (std::size_t c = 0; c < 6; ++c) {
      const auto component = static_cast<Eigen::Index>((turn ? 6 : 0) + c);
      ChangeMode mode{error_symbol(c, turn ? 'C' : tilt_letter),
                      component_unit(c),
                      turn ? at : tilts,
                      {},
                      every_sixth(turn ? split.turn : split.tilt, static_cast<Eigen::Index>(c))};
      mode.design = Eigen::MatrixXd::Zero(6 * n, static_cast<Eigen::Index>(mode.places.size()));
      std::optional<Eigen::Index> at_reference;  // a change there is seen, with the other sign, everywhere else
      for (std::size_t k = 0, tilt = 0; k < at.size(); ++k) {
        while (tilts[tilt].a != at[k].a) ++tilt;
        const auto column = static_cast<Eigen::Index>(turn ? k : tilt);
        mode.design.block<6, 1>(6 * static_cast<Eigen::Index>(k), column) =
            relative_error_jacobian(chain, at[k], {}).here.col(component);
        if (same_station(at[k].a, Angle()) && (!turn || same_station(at[k].c, Angle()))) at_reference = column;
      }
      for (std::size_t k = 0; at_reference && k < at.size(); ++k)
        mode.design.block<6, 1>(6 * static_cast<Eigen::Index>(k), *at_reference) +=
            relative_error_jacobian(chain, at[k], {}).reference.col(component);
      functions.push_back(std::move(mode));
    }
  return functions;
}

void add_parameters(SeriesSet& set, const std::vector<const Model*>& models, const std::vector<std::size_t>& indices) {
  std::map<std::string, ErrorSeries> found;
  for (std::size_t k = 0; k < models.size(); ++k)
    for (const EffectPtr& effect : models[k]->effects) {
      if (!effect->is_compensated() || effect->id() == "rotary_error_map" || effect->covariance().size() == 0)
        continue;
      for (std::size_t p = 0; p < effect->parameters().size(); ++p) {
        const Parameter& parameter = effect->parameters()[p];
        ErrorSeries& series = found[effect->id() + " " + parameter.name];
        series.name = effect->id() + " " + parameter.name;
        series.unit = parameter.unit;
        const auto i = static_cast<Eigen::Index>(p);
        series.points.push_back({indices[k], Eigen::VectorXd::Constant(1, parameter.value),
                                 Eigen::MatrixXd::Constant(1, 1, effect->covariance()(i, i))});
      }
    }
  for (auto& [name, series] : found)
    if (series.points.size() > 1) set.parameters.push_back(std::move(series));
}

}  // namespace

SeriesSet error_series(std::span<const DatedModel> models, const Machine& machine) {
  SeriesSet set;
  std::vector<const Model*> used;
  std::vector<std::size_t> indices;
  for (std::size_t k = 0; k < models.size(); ++k) {
    if (usable(models[k].model))
      used.push_back(&models[k].model), indices.push_back(k);
    else
      set.left_out.push_back(k);
  }
  if (used.empty()) return set;
  add_parameters(set, used, indices);
  const EffectContext context = effect_context(machine);
  const std::vector<std::vector<SplitNode>> rows = common_nodes(used);
  const std::vector<IndexedPosition> at = positions(rows);
  if (at.empty()) return set;

  std::vector<Stacked> stacked;
  const auto n = 6 * static_cast<Eigen::Index>(at.size());
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(n, n);
  for (const Model* model : used) {
    stacked.push_back(stacked_pose_errors(*model, at, context));
    mean += stacked.back().covariance / static_cast<double>(used.size());
  }
  const EffectPtr location = make_location_errors(context);
  Eigen::MatrixXd design(n, static_cast<Eigen::Index>(location->parameters().size()));
  for (std::size_t k = 0; k < at.size(); ++k)
    design.middleRows<6>(6 * static_cast<Eigen::Index>(k)) = location->basis(at_position(at[k]));
  Eigen::VectorXd scale(design.cols());
  for (Eigen::Index k = 0; k < scale.size(); ++k)
    scale[k] = from_unit(1, location->parameters()[static_cast<std::size_t>(k)].unit);
  const Eigen::MatrixXd gain = least_squares_gain(design, mean, scale);
  const auto series = [&](const std::string& name, Unit unit, std::vector<IndexedPosition> places,
                          const Eigen::MatrixXd& map) {
    ErrorSeries result{.name = name, .unit = unit, .places = std::move(places)};
    for (std::size_t k = 0; k < stacked.size(); ++k)
      result.points.push_back({indices[k], map * stacked[k].delta, map * stacked[k].covariance * map.transpose()});
    return result;
  };
  for (std::size_t p = 0; p < static_cast<std::size_t>(gain.rows()); ++p) {
    const Parameter& parameter = location->parameters()[p];
    const auto k = static_cast<Eigen::Index>(p);
    set.locations.push_back(series(parameter.name, parameter.unit, {}, gain.row(k)));
    set.poses.modes.push_back({parameter.name, parameter.unit, {}, design.col(k), {}});
  }
  for (ChangeMode& f : functions_of(*context.chain, machine.tilt_letter(), rows)) {
    set.functions.push_back(series(f.name, f.unit, f.places, f.shown));
    set.poses.modes.push_back(std::move(f));
  }
  for (std::size_t k = 0; k < stacked.size(); ++k)
    set.poses.points.push_back({indices[k], std::move(stacked[k].delta), std::move(stacked[k].covariance)});
  return set;
}

}  // namespace trunnion
