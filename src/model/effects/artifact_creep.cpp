#include <algorithm>
#include <cmath>

#include "model/effects/artifact_effects.h"
#include "model/effects/columns.h"
#include "model/effects/families.h"
#include "model/effects/formula_effect.h"

namespace trunnion {
namespace {

/// A body that relaxes in its clamp:  it moves in W by g (1 - exp(-t / tau)); for a tau far beyond the time measured
/// that is a steady creep. `artifact_creep` is all bodies alike, `artifact_creep:LABEL` one of them.
Formula artifact_creep(const std::string& detail, double time_constant_s, const EffectContext& context) {
  const std::string label = detail.empty() ? std::string(kAllArtifacts) : detail;
  Formula formula{
      .id = detail.empty() ? "artifact_creep" : "artifact_creep:" + detail,
      .origin = Origin::measurement,
      .depends_on = {"artifact", "time_s"},
      .shape = {{"time_constant", Unit::s, time_constant_s}},
      .shape_ranges = {{.low = 1e-3, .high = 1e9}},
      .basis =
          [label, chain = context.chain](const Situation& s, const Eigen::VectorXd& shape) {
            const double rise = concerns(s, label) ? -std::expm1(-std::max(0.0, s.time_s) / shape[0]) : 0;
            return steps_in_w(*chain, s, rise);
          },
  };
  if (detail.empty()) formula.depends_on = {"time_s"};
  for (const char* name : {"X", "Y", "Z"}) formula.parameters.push_back({name, Unit::um, 0, from_unit(200, Unit::um)});
  return formula;
}

std::vector<EffectPtr> creeps(const CandidateScope& scope) {
  std::vector<EffectPtr> found;
  const std::optional<ColumnRange> time = spread(scope, "time_s");
  if (!time) return found;
  std::vector<std::string> details = {""};
  if (scope.artifacts.size() > 1) details.insert(details.end(), scope.artifacts.begin(), scope.artifacts.end());
  for (const std::string& detail : details)
    for (const double share : {0.08, 0.35, 3.0})
      found.push_back(make_effect(artifact_creep(detail, share * time->width(), scope.context)));
  return found;
}

}  // namespace

Family artifact_creep_family() {
  return {
      .name = "artifact_creep",
      .what = "a probed body relaxes slowly in its clamp",
      .remedy = "the body's spots at the reference pose several times over, with time_s recorded",
      .candidates = creeps,
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext& context) -> EffectPtr {
        return make_effect(artifact_creep(detail, 600, context), json);
      },
  };
}

}  // namespace trunnion
