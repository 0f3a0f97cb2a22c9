#include "io/identification_report.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "io/provenance.h"

namespace trunnion {

using nlohmann::json;

namespace {

json outlier_json(const IdentificationResult& r, const Outlier& o) {
  const Reading& reading = r.problem.readings[o.reading];
  const double unit = reading.angular ? 1e6 : 1e3;
  return {{"line", r.problem.observations->rows[reading.row].line},
          {reading.angular ? "residual_urad" : "residual_um", unit * o.residual},
          {"normalised", o.normalised}};
}

json position_json(IndexedPosition at, char tilt) {
  return {{std::string(1, tilt) + "_deg", at.a.in_degrees()}, {"C_deg", at.c.in_degrees()}};
}

/// {"axis": "C", "angle_deg", "displacement_rms_um", "poses"}; the check poses have no axis and no angle.
json left_out_json(const LeftOutAngle& left, char tilt) {
  json j = {{"displacement_rms_um", left.score_um}, {"poses", left.poses}};
  if (left.of == LeftOutAngle::Of::check_poses) return j;
  j["axis"] = left.of == LeftOutAngle::Of::turn ? "C" : std::string(1, tilt);
  j["angle_deg"] = left.angle.in_degrees();
  return j;
}

}  // namespace

json identification_json(const IdentificationResult& r, const Machine& machine,
                         const std::vector<std::string>& inputs) {
  const char tilt = machine.tilt_letter();
  json j;
  j["method"] = r.method == IdentificationMethod::joint ? "joint" : "two-step";
  j["readings"] = r.readings;
  j["unknowns"] = r.unknowns;
  j["rank"] = r.rank;
  j["degrees_of_freedom"] = r.freedom;
  j["condition"] = r.condition;
  j["sigma_declared_um"] = r.sigma_from_readings ? json() : json(r.sigma_declared_um);
  j["sigma_found_um"] = r.sigma_found_um;
  j["reduced_chi2"] = r.reduced_chi_square;
  j["chi2_p"] = r.chi_square_p;
  j["uncertainty_scale"] = r.uncertainty_scale;
  j["worst_redundancy"] = r.worst_redundancy;
  j["outliers"] = json::array();
  for (const Outlier& o : r.outliers) j["outliers"].push_back(outlier_json(r, o));
  if (!r.crowd.empty()) {
    json rows = json::array();
    for (const Outlier& o : r.crowded) rows.push_back(outlier_json(r, o));
    j["crowd"] = {{"where", r.crowd}, {"readings", std::move(rows)}};
  }
  j["unchecked_lines"] = json::array();
  for (const std::size_t i : r.unchecked)
    j["unchecked_lines"].push_back(r.problem.observations->rows[r.problem.readings[i].row].line);
  j["unseen_freedoms"] = json::array();
  static const char* const kComponents[] = {"Dx", "Dy", "Dz", "Da", "Db", "Dc"};
  for (const UnseenFreedom& f : r.unseen) {
    json entry = position_json(r.problem.poses[f.pose].at, tilt);
    json components = json::array(), direction = json::array();
    for (const std::size_t c : f.components) components.push_back(kComponents[c]);
    for (Eigen::Index k = 0; k < 6; ++k) direction.push_back(std::abs(f.direction[k]) < 1e-12 ? 0.0 : f.direction[k]);
    entry["components"] = std::move(components);
    entry["direction_mm_and_rad_at_100_mm"] = std::move(direction);
    j["unseen_freedoms"].push_back(std::move(entry));
  }
  j["undetermined"] = r.undetermined;
  j["interpolated_nodes"] = json::array();
  for (const IndexedPosition& at : r.interpolated_nodes) j["interpolated_nodes"].push_back(position_json(at, tilt));
  if (!r.location.symbols.empty()) {
    json values = json::object();
    for (std::size_t k = 0; k < r.location.symbols.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      const Unit unit = r.location.units[k];
      values[r.location.symbols[k]] = {{"value", to_unit(r.location.values[i], unit)},
                                       {"std", to_unit(std::sqrt(r.location.covariance(i, i)), unit)},
                                       {"unit", unit_text(unit).text}};
    }
    j["location_errors"] = {{"values", std::move(values)},
                            {"chi2", r.location.chi_square},
                            {"degrees_of_freedom", r.location.freedom},
                            {"p_value", r.location.p_value},
                            {"location_errors_only", r.location.p_value > 0.01}};
  }
  json errors = json::object();
  for (const ErrorFinding& e : r.errors) {
    errors[e.symbol] = {{"largest", to_unit(e.largest, e.unit)},
                        {"std", to_unit(e.largest_std, e.unit)},
                        {"unit", unit_text(e.unit).text},
                        {"at", position_json(e.largest_at, tilt)},
                        {"rms_std", to_unit(e.rms_std, e.unit)},
                        {"p_value", e.p_value},
                        {"told_from_zero", e.told_from_zero},
                        {"nodes", e.nodes},
                        {"nodes_unseen", e.unseen}};
    if (!e.seen())
      for (const char* none : {"largest", "std", "at", "rms_std", "p_value"}) errors[e.symbol][none] = nullptr;
    if (e.seen() && e.symbol.back() != 'C') errors[e.symbol]["at"].erase("C_deg");
  }
  j["errors"] = std::move(errors);
  json evidence = json::object();
  for (const InterpolationEvidence& e : r.interpolation) {
    json angles = json::array();
    for (const LeftOutAngle& left : e.angles) angles.push_back(left_out_json(left, tilt));
    evidence[e.method] = {{"displacement_rms_um", e.score_um},
                          {"D_rms_um", e.rms_um},
                          {"theta_rms_urad", e.rms_urad},
                          {"poses", e.poses},
                          {"angles", std::move(angles)}};
  }
  j["interpolation"] = {{"chosen", r.chosen_interpolation}, {"left_out_angles", std::move(evidence)}};
  if (r.belief)
    j["prior"] = {{"chi2", r.belief->chi_square},
                  {"degrees_of_freedom", r.belief->freedom},
                  {"p_value", r.belief->p_value},
                  {"misfit_of_its_nodes", r.belief->misfit}};
  j.update(provenance_json(inputs));
  return j;
}

}  // namespace trunnion
