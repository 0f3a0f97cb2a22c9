#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "model/effects/artifact_effects.h"
#include "model/effects/columns.h"
#include "model/effects/families.h"
#include "model/effects/formula_effect.h"

namespace trunnion {
namespace {

constexpr const char* kDefaultColumn = "temperature_C";

/// The probed bodies and the table under them grow by alpha a from W's origin, a point at q in W moves by alpha a q.
/// What `a` is, the id says:
///   artifact_expansion           a = temperature_C beyond its zero, or time_s if its entry says "column": "time_s",
///   artifact_expansion:COLUMN    a = another column beyond its zero,
///   artifact_expansion:warm_up   a = 1 - exp(-t / tau).
/// With a further ":height" only heights grow, q = (0, 0, q_z).
Formula artifact_expansion(const std::string& detail, double time_constant_s, const EffectContext& context) {
  std::string column = detail;
  bool height = false;
  if (column == "height") column.clear(), height = true;
  if (column.ends_with(":height")) column.resize(column.size() - 7), height = true;
  const bool warm_up = column == "warm_up";
  if (column.empty()) column = kDefaultColumn;
  const Unit unit = column == "time_s"       ? Unit::um_per_m_per_h
                    : is_temperature(column) ? Unit::um_per_m_per_K
                                             : Unit::um_per_m;
  Formula formula{
      .id = detail.empty() || detail == "time_s" ? "artifact_expansion" : "artifact_expansion:" + detail,
      .origin = Origin::measurement,
      .depends_on = {warm_up ? "time_s" : column, "x_mm", "y_mm", "z_mm"},
      .parameters = {{"expansion", unit, 0, from_unit(unit == Unit::um_per_m_per_K ? 40 : 500, unit)}},
  };
  if (detail == "time_s") formula.keys = {{"column", detail}};
  if (warm_up) {
    formula.shape = {{"time_constant", Unit::s, time_constant_s}};
    formula.shape_ranges = {{.low = 1e-3, .high = 1e9}};
  }
  formula.basis = [=, chain = context.chain](const Situation& s, const Eigen::VectorXd& shape) {
    Matrix6Xd b = Matrix6Xd::Zero(6, 1);
    if (!concerns(s, kAllArtifacts)) return b;
    const double growth = warm_up ? -std::expm1(-std::max(0.0, s.time_s) / shape[0]) : beyond_zero(s, column);
    const Eigen::Isometry3d r_from_w = chain->r_from_w(s.at);
    Eigen::Vector3d q = r_from_w.inverse() * s.point_r_mm;
    if (height) q.head<2>().setZero();
    b.topRows<3>() = growth * (r_from_w.linear() * q);
    return b;
  };
  return formula;
}

std::vector<EffectPtr> candidates(const CandidateScope& scope) {
  std::vector<EffectPtr> found;
  const auto add = [&](const std::string& column, double time_constant_s) {
    found.push_back(make_effect(artifact_expansion(column, time_constant_s, scope.context)));
    found.push_back(make_effect(
        artifact_expansion(column.empty() ? "height" : column + ":height", time_constant_s, scope.context)));
  };
  for (const std::string& column : temperature_columns(scope)) add(column == kDefaultColumn ? "" : column, 0);
  if (const std::optional<ColumnRange> time = spread(scope, "time_s")) {
    add("time_s", 0);
    for (const double share : {0.1, 0.4}) add("warm_up", share * time->width());
  }
  if (spread(scope, "repeat")) add("repeat", 0);
  return found;
}

}  // namespace

Family artifact_expansion_family() {
  return {
      .name = "artifact_expansion",
      .what = "the probed bodies grow with temperature or time",
      .remedy = "the reference pose once more at another temperature, with temperature_C recorded",
      .candidates = candidates,
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext& context) -> EffectPtr {
        const bool by_time = detail.empty() && json.contains("column") && json["column"] == "time_s";
        return make_effect(artifact_expansion(by_time ? "time_s" : detail, 600, context), json);
      },
  };
}

}  // namespace trunnion
