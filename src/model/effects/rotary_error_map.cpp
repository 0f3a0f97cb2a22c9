#include "model/effects/rotary_error_map.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "error.h"
#include "geometric_errors/symbol.h"
#include "model/effects/families.h"
#include "model/json_value.h"
#include "units/number_text.h"

namespace trunnion {

using nlohmann::json;

namespace {

const IndexedPosition kReference{};

ToolPlace tool_place(const Situation& s) { return {s.point_r_mm, s.tool_length_mm}; }

/// Seven significant digits are far below any uncertainty's own, and keep files small.
double rounded(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::scientific, 6).ptr;
  double result = 0;
  std::from_chars(text, end, result);
  return result;
}

Unit coefficient_unit(Eigen::Index k) { return component_unit(static_cast<std::size_t>(k % 6)); }

/// Node values whose covariances are written, eight million: a hundred megabytes. Beyond, their standard uncertainties.
constexpr Eigen::Index kMostCorrelated = 4095;

json packed(const Eigen::MatrixXd& covariance) {
  json entries = json::array();
  for (Eigen::Index r = 0; r < covariance.rows(); ++r)
    for (Eigen::Index c = 0; c <= r; ++c)
      entries.push_back(rounded(to_unit(to_unit(covariance(r, c), coefficient_unit(r)), coefficient_unit(c))));
  return entries;
}

Eigen::MatrixXd unpacked(const json& entries, Eigen::Index n, const std::string& where) {
  if (!entries.is_array() || static_cast<Eigen::Index>(entries.size()) != n * (n + 1) / 2)
    throw ModelError(where + ": a lower triangle of " + std::to_string(n * (n + 1) / 2) + " numbers is wanted");
  Eigen::MatrixXd m(n, n);
  std::size_t k = 0;
  for (Eigen::Index r = 0; r < n; ++r)
    for (Eigen::Index c = 0; c <= r; ++c)
      m(r, c) = m(c, r) = from_unit(from_unit(number(entries[k++], where), coefficient_unit(r)), coefficient_unit(c));
  return m;
}

std::vector<Angle> stations(const json& grid, const std::string& axis) {
  const std::string where = "rotary_error_map: grid_deg." + axis;
  const json& list = member(grid, axis.c_str(), "rotary_error_map: grid_deg");
  if (!list.is_array() || list.empty()) throw ModelError(where + ": a list of angles is wanted");
  std::vector<Angle> result;
  for (const json& entry : list) result.push_back(Angle::degrees(number(entry, where)));
  return result;
}

/// Calls `visit(symbol, unit, row, column or -1, coefficient)` for every number of the map.
template <class Visit>
void for_each_value(const ErrorGrid& grid, char tilt_letter, Visit visit) {
  for (std::size_t k = 0; k < 6; ++k)
    for (std::size_t i = 0; i < grid.a_stations.size(); ++i)
      visit(error_symbol(k, tilt_letter), component_unit(k), i, -1, grid.tilt_offset(i) + k);
  for (std::size_t k = 0; k < 6; ++k)
    for (std::size_t i = 0; i < grid.a_stations.size(); ++i)
      for (std::size_t j = 0; j < grid.c_stations.size(); ++j)
        visit(error_symbol(k, 'C'), component_unit(k), i, static_cast<int>(j), grid.turn_offset(i, j) + k);
}

/// `{"EXA": {"unit", "data"}, …}` of one number per coefficient, null where `blank`.
template <class Value>
json value_table(const ErrorGrid& grid, char tilt_letter, Value value) {
  json table = json::object();
  for_each_value(grid, tilt_letter, [&](const std::string& symbol, Unit unit, std::size_t i, int j, std::size_t k) {
    json& entry = table[symbol];
    if (entry.is_null()) entry = {{"unit", unit_text(unit).text}, {"data", json::array()}};
    json& data = entry["data"];
    const json cell = value(static_cast<Eigen::Index>(k), unit);
    if (j < 0) {
      data.push_back(cell);
    } else {
      if (data.size() <= i) data.push_back(json::array());
      data[i].push_back(cell);
    }
  });
  return table;
}

/// Reads such a table; a null leaves NaN for the caller to sort out.
Eigen::VectorXd read_value_table(const json& table, const std::string& name, const ErrorGrid& grid, char tilt_letter) {
  const std::string where = "rotary_error_map: " + name;
  if (!table.is_object()) throw ModelError(where + ": an object with EX" + tilt_letter + " … ECC is wanted");
  for (const auto& [symbol, entry] : table.items()) {
    bool known = false;
    for (std::size_t k = 0; k < 6; ++k)
      known = known || symbol == error_symbol(k, tilt_letter) || symbol == error_symbol(k, 'C');
    if (!known) throw ModelError(where + "." + symbol + ": not an error of this map");
    (void)entry;
  }
  Eigen::VectorXd values(static_cast<Eigen::Index>(grid.coefficient_count()));
  for_each_value(grid, tilt_letter, [&](const std::string& symbol, Unit unit, std::size_t i, int j, std::size_t k) {
    const std::string key = where + "." + symbol;
    const json& entry = member(table, symbol.c_str(), where);
    if (member(entry, "unit", key) != unit_text(unit).text)
      throw ModelError(key + ".unit: " + entry["unit"].dump() + " found, \"" + std::string(unit_text(unit).text) +
                       "\" is wanted");
    const json& data = member(entry, "data", key);
    const std::size_t rows = grid.a_stations.size();
    if (!data.is_array() || data.size() != rows)
      throw ModelError(key + ".data: " + (data.is_array() ? std::to_string(data.size()) : data.dump()) +
                       " rows found, " + std::to_string(rows) + " (one per " + tilt_letter + ") are wanted");
    const json* cell = &data[i];
    if (j >= 0) {
      if (!cell->is_array() || cell->size() != grid.c_stations.size())
        throw ModelError(key + ".data[" + std::to_string(i) +
                         "]: " + (cell->is_array() ? std::to_string(cell->size()) : cell->dump()) + " values found, " +
                         std::to_string(grid.c_stations.size()) + " (one per C) are wanted");
      cell = &(*cell)[static_cast<std::size_t>(j)];
    }
    values[static_cast<Eigen::Index>(k)] =
        cell->is_null() ? std::nan("") : from_unit(number(*cell, key + ".data"), unit);
  });
  return values;
}

/// "EXA at A -30", "EXC at A -30 C 60": a value of the grid.
std::string node_name(const ErrorGrid& grid, char tilt_letter, const std::string& symbol, std::size_t i, int j) {
  const std::string at = printed("%s at %c %.6g", symbol.c_str(), tilt_letter, grid.a_stations[i].in_degrees());
  return j < 0 ? at : at + formatted(" C %.6g", grid.c_stations[static_cast<std::size_t>(j)].in_degrees());
}

void name_parameters(std::vector<Parameter>& parameters, const ErrorGrid& grid, char tilt_letter) {
  const Eigen::VectorXd values = grid.coefficients();
  parameters.resize(static_cast<std::size_t>(values.size()));
  for_each_value(grid, tilt_letter, [&](const std::string& symbol, Unit unit, std::size_t i, int j, std::size_t k) {
    parameters[k] = {node_name(grid, tilt_letter, symbol, i, j), unit, values[static_cast<Eigen::Index>(k)]};
  });
}

void name_parameters(std::vector<Parameter>& parameters, const HarmonicBasis& basis, const Eigen::VectorXd& values,
                     char tilt_letter) {
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    const Eigen::Index function = k / 6, turn = function - basis.tilt_functions();
    std::string name = error_symbol(static_cast<std::size_t>(k % 6), turn < 0 ? tilt_letter : 'C') + ":";
    if (turn < 0) {
      name += "P" + std::to_string(function);
    } else if (turn == 0) {
      name += "mean";
    } else {
      const Eigen::Index per_wave = basis.turn_degree + 1, wave = (turn - 1) / per_wave;
      name +=
          (wave % 2 == 0 ? "cos" : "sin") + std::to_string(wave / 2 + 1) + ":" + std::to_string((turn - 1) % per_wave);
    }
    parameters.push_back({std::move(name), coefficient_unit(k), values[k]});
  }
}

/// What the grid's coefficients are, linear in those of the surface.
Eigen::MatrixXd surface_at_nodes(const ErrorSurface& surface, const ErrorGrid& grid) {
  Eigen::MatrixXd m(static_cast<Eigen::Index>(grid.coefficient_count()), surface.coefficient_count());
  for (std::size_t i = 0; i < grid.a_stations.size(); ++i)
    for (std::size_t j = 0; j < grid.c_stations.size(); ++j) {
      const Eigen::MatrixXd rows = surface.jacobian({grid.a_stations[i], grid.c_stations[j]});
      m.middleRows(static_cast<Eigen::Index>(grid.tilt_offset(i)), 6) = rows.topRows(6);
      m.middleRows(static_cast<Eigen::Index>(grid.turn_offset(i, j)), 6) = rows.bottomRows(6);
    }
  return m;
}

}  // namespace

RotaryErrorMap::RotaryErrorMap(RotaryMapContent content, const EffectContext& context)
    : content_(std::move(content)), context_(context) {
  std::unique_ptr<ErrorSurface> nodes = make_surface(content_.interpolation, content_.grid);
  if (content_.smooth_basis) {
    use(std::make_shared<HarmonicSurface>(*content_.smooth_basis, content_.smooth_coefficients));
    covariance_ = content_.smooth_covariance;
    name_parameters(parameters_, *content_.smooth_basis, content_.smooth_coefficients, context_.tilt_letter);
  } else {
    use(std::move(nodes));
    covariance_ = content_.grid_covariance;
    name_parameters(parameters_, content_.grid, context_.tilt_letter);
  }
}

void RotaryErrorMap::use(std::shared_ptr<const ErrorSurface> surface) {
  surface_ = std::move(surface);
  if (!surface_->covers(Angle()))
    throw ModelError(
        "rotary_error_map: its tilt stations do not reach the reference pose 0, where the workpiece is set up");
  reference_ = surface_->at(kReference);
  reference_jacobian_ = surface_->jacobian(kReference);
}

void RotaryErrorMap::parameters_changed() {
  if (!content_.smooth_basis) {
    content_.grid = with_coefficients(content_.grid, values());
    content_.grid_covariance = covariance_;
    content_.full_covariance = covariance_.size() != 0;
    use(make_surface(content_.interpolation, content_.grid));
    return;
  }
  const Eigen::VectorXd change = values() - content_.smooth_coefficients;
  content_.smooth_coefficients = values();
  content_.smooth_covariance = covariance_;
  use(std::make_shared<HarmonicSurface>(*content_.smooth_basis, content_.smooth_coefficients));
  const Eigen::MatrixXd at_nodes = surface_at_nodes(*surface_, content_.grid);
  content_.grid = with_coefficients(content_.grid, content_.grid.coefficients() + at_nodes * change);
  content_.grid_covariance.resize(0, 0);
  if (covariance_.size() != 0) content_.grid_covariance = at_nodes * covariance_ * at_nodes.transpose();
  content_.full_covariance = covariance_.size() != 0;
}

bool RotaryErrorMap::moves_table() const { return context_.chain->has_rotary(Side::workpiece); }

std::vector<std::string> RotaryErrorMap::depends_on() const {
  return {std::string(1, context_.tilt_letter) + "_deg", "C_deg"};
}

bool RotaryErrorMap::has_uncertainty() const { return covariance_.size() != 0; }

std::vector<std::string> RotaryErrorMap::unseen_freedoms() const {
  std::vector<std::string> names;
  if (content_.unseen.empty()) return names;
  for_each_value(content_.grid, context_.tilt_letter,
                 [&](const std::string& symbol, Unit, std::size_t i, int j, std::size_t k) {
                   if (content_.unseen[k])
                     names.push_back(node_name(content_.grid, context_.tilt_letter, symbol, i, j));
                 });
  return names;
}

bool RotaryErrorMap::touches_unseen(IndexedPosition position) const {
  if (!content_.smooth_basis) return true;
  const ErrorGrid& grid = content_.grid;
  const auto nearest = [](const std::vector<Angle>& stations, Angle at, bool periodic) {
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < stations.size(); ++k) {
      double gap = (at - stations[k]).in_radians();
      if (periodic) gap = std::remainder(gap, kFullTurn.in_radians());
      if (std::abs(gap) < least) least = std::abs(gap), best = k;
    }
    return best;
  };
  const std::size_t i = nearest(grid.a_stations, position.a, false), j = nearest(grid.c_stations, position.c, true);
  for (std::size_t k = 0; k < 6; ++k)
    if (content_.unseen[grid.tilt_offset(i) + k] || content_.unseen[grid.turn_offset(i, j) + k]) return true;
  return false;
}

void RotaryErrorMap::refuse_unseen(IndexedPosition position) const {
  if (content_.filled || content_.unseen.empty()) return;
  const auto unseen = std::count(content_.unseen.begin(), content_.unseen.end(), true);
  if (unseen == 0 || !touches_unseen(position)) return;
  throw RangeError(
      "the map holds " + std::to_string(unseen) + " errors that no measurement determined (" +
      unseen_freedoms().front() + (unseen > 1 ? ", …" : "") +
      "), and they are needed here; measure those poses again, or let identify fill them by its smooth fit (--fill)");
}

Matrix6Xd RotaryErrorMap::basis(const Situation& s) const {
  refuse_unseen(s.at);
  const RelativeErrorJacobian j = relative_error_jacobian(*context_.chain, s.at, tool_place(s));
  return j.here * surface_->jacobian(s.at) + j.reference * reference_jacobian_;
}

PoseError RotaryErrorMap::at(const Situation& s) const {
  refuse_unseen(s.at);
  return relative_pose_error(*context_.chain, s.at, surface_->at(s.at), reference_, tool_place(s));
}

Matrix6d RotaryErrorMap::covariance_at(const Situation& s) const {
  if (!has_uncertainty()) return Matrix6d::Zero();
  const Matrix6Xd b = basis(s);
  Matrix6d covariance = b * covariance_ * b.transpose();
  covariance.topLeftCorner<3, 3>().diagonal().array() += std::pow(content_.interpolation_sigma_mm, 2);
  covariance.bottomRightCorner<3, 3>().diagonal().array() += std::pow(content_.interpolation_sigma_rad, 2);
  return covariance;
}

json RotaryErrorMap::to_json() const {
  const ErrorGrid& grid = content_.grid;
  const char letter = context_.tilt_letter;
  json j;
  j["id"] = id();
  j["origin"] = "machine";
  const auto degrees = [](const std::vector<Angle>& list) {
    json out = json::array();
    // An angle that came from whole thousandths of a degree goes back to them.
    for (const Angle a : list)
      out.push_back(std::abs(a.in_degrees() * 1e6 - std::round(a.in_degrees() * 1e6)) < 1e-5
                        ? std::round(a.in_degrees() * 1e6) / 1e6
                        : a.in_degrees());
    return out;
  };
  j["grid_deg"] = {{std::string(1, letter), degrees(grid.a_stations)}, {"C", degrees(grid.c_stations)}};
  const Eigen::VectorXd values = grid.coefficients();
  const auto unseen = [&](Eigen::Index k) {
    return !content_.unseen.empty() && content_.unseen[static_cast<std::size_t>(k)];
  };
  j["values"] = value_table(
      grid, letter, [&](Eigen::Index k, Unit unit) { return unseen(k) ? json() : json(to_unit(values[k], unit)); });
  if (content_.grid_covariance.size() != 0) {
    j["std"] = value_table(grid, letter, [&](Eigen::Index k, Unit unit) {
      return unseen(k) ? json() : json(to_unit(std::sqrt(std::max(0.0, content_.grid_covariance(k, k))), unit));
    });
    if (content_.full_covariance && content_.grid_covariance.rows() <= kMostCorrelated)
      j["covariance"] = packed(content_.grid_covariance);
  }
  json interpolation = {{"method", content_.smooth_basis ? content_.smooth_method
                                                         : std::string(interpolation_name(content_.interpolation))},
                        {"sigma_um", to_unit(content_.interpolation_sigma_mm, Unit::um)},
                        {"sigma_urad", to_unit(content_.interpolation_sigma_rad, Unit::urad)}};
  if (content_.smooth_basis) {
    const HarmonicBasis& basis = *content_.smooth_basis;
    if (content_.filled) interpolation["filled"] = true;
    interpolation["tilt_degree"] = basis.tilt_degree;
    interpolation["harmonics"] = basis.harmonics;
    interpolation["turn_degree"] = basis.turn_degree;
    json coefficients = json::array();
    for (Eigen::Index k = 0; k < content_.smooth_coefficients.size(); ++k)
      coefficients.push_back(to_unit(content_.smooth_coefficients[k], coefficient_unit(k)));
    interpolation["coefficients"] = std::move(coefficients);
    if (content_.smooth_covariance.size() != 0) interpolation["covariance"] = packed(content_.smooth_covariance);
  }
  j["interpolation"] = std::move(interpolation);
  return j;
}

std::shared_ptr<RotaryErrorMap> RotaryErrorMap::read(const json& j, const EffectContext& context) {
  const std::string tilt(1, context.tilt_letter);
  RotaryMapContent content;
  const json& grid_deg = member(j, "grid_deg", "rotary_error_map");
  for (const auto& [axis, list] : grid_deg.items())
    if (axis != tilt && axis != "C")
      throw ModelError("rotary_error_map: grid_deg." + axis + ": the machine's rotary axes are " + tilt + " and C");
  content.grid = zero_grid(stations(grid_deg, tilt), stations(grid_deg, "C"));
  Eigen::VectorXd values =
      read_value_table(member(j, "values", "rotary_error_map"), "values", content.grid, context.tilt_letter);
  if (values.array().isNaN().any()) {
    content.unseen.assign(static_cast<std::size_t>(values.size()), false);
    for (Eigen::Index k = 0; k < values.size(); ++k)
      if (std::isnan(values[k])) content.unseen[static_cast<std::size_t>(k)] = true, values[k] = 0;
  }
  content.grid = with_coefficients(content.grid, values);
  const auto n = static_cast<Eigen::Index>(content.grid.coefficient_count());
  if (j.contains("covariance")) {
    content.grid_covariance = unpacked(j["covariance"], n, "rotary_error_map: covariance");
    content.full_covariance = true;
  } else if (j.contains("std")) {
    Eigen::VectorXd std = read_value_table(j["std"], "std", content.grid, context.tilt_letter);
    for (Eigen::Index k = 0; k < n; ++k) {
      if (std::isnan(std[k])) std[k] = 0;
      if (std[k] < 0) throw ModelError("rotary_error_map: std: a negative standard uncertainty");
    }
    content.grid_covariance = std.cwiseAbs2().asDiagonal();
  }
  if (j.contains("interpolation")) {
    const json& entry = j["interpolation"];
    const std::string where = "rotary_error_map: interpolation";
    const json& method = member(entry, "method", where);
    const std::string name = method.is_string() ? method.get<std::string>() : method.dump();
    if (entry.contains("sigma_um"))
      content.interpolation_sigma_mm = from_unit(number(entry["sigma_um"], where + ".sigma_um"), Unit::um);
    if (entry.contains("sigma_urad"))
      content.interpolation_sigma_rad = from_unit(number(entry["sigma_urad"], where + ".sigma_urad"), Unit::urad);
    if (name == "structured" || name == "gaussian-process") {
      HarmonicBasis basis{.a_range = {content.grid.a_stations.front(), content.grid.a_stations.back()}};
      const auto whole = [&](const char* key) {
        const double value = number(member(entry, key, where), where + "." + key);
        if (value != std::floor(value) || value < 0 || value > 64)
          throw ModelError(where + "." + key + ": a whole number of 0 to 64 is wanted");
        return static_cast<int>(value);
      };
      basis.tilt_degree = whole("tilt_degree");
      basis.harmonics = whole("harmonics");
      basis.turn_degree = whole("turn_degree");
      if (basis.turn_degree > 4) throw ModelError(where + ".turn_degree: 0 to 4 is wanted");
      const json& list = member(entry, "coefficients", where);
      if (!list.is_array() || static_cast<Eigen::Index>(list.size()) != basis.coefficient_count())
        throw ModelError(where + ".coefficients: " + std::to_string(basis.coefficient_count()) + " numbers are wanted");
      content.smooth_coefficients.resize(basis.coefficient_count());
      for (Eigen::Index k = 0; k < basis.coefficient_count(); ++k)
        content.smooth_coefficients[k] =
            from_unit(number(list[static_cast<std::size_t>(k)], where + ".coefficients"), coefficient_unit(k));
      if (entry.contains("covariance"))
        content.smooth_covariance = unpacked(entry["covariance"], basis.coefficient_count(), where + ".covariance");
      content.filled = entry.contains("filled") && entry["filled"] == true;
      content.smooth_basis = basis;
      content.smooth_method = name;
    } else if (const auto found = interpolation_from_name(name)) {
      content.interpolation = *found;
    } else {
      throw ModelError(
          where + ".method: \"" + name +
          "\" found, one of trig-cubic, bilinear, natural-neighbour, structured, gaussian-process is wanted");
    }
  }
  return std::make_shared<RotaryErrorMap>(std::move(content), context);
}

Family rotary_error_map_family() {
  return {
      .name = "rotary_error_map",
      .what = "the twelve errors of the rotary axes over A and C",
      .remedy = "probing at a grid of A and C",
      .candidates =
          [](const CandidateScope&) { return std::vector<EffectPtr>(); },  // it is the base, never a candidate
      .read = [](const std::string&, const json& j, const EffectContext& context) -> EffectPtr {
        return RotaryErrorMap::read(j, context);
      },
  };
}

}  // namespace trunnion
