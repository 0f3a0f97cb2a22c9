#include "model/effects/columns.h"
#include "model/effects/families.h"
#include "model/effects/formula_effect.h"
#include "model/effects/probe_effects.h"

namespace trunnion {
namespace {

/// Axial against lateral pretravel (or stylus bending):  y = t n_z^2. What is the same in all directions is hidden in
/// the places of the spots.
Formula probe_pretravel(const std::string& detail) {
  if (!detail.empty()) refuse_detail("probe_pretravel", detail, "nothing");
  return {
      .id = "probe_pretravel",
      .origin = Origin::measurement,
      .depends_on = {"nz"},
      .parameters = {{"axial", Unit::um}},
      .basis = [](const Situation& s,
                  const Eigen::VectorXd&) { return along_approach(s, s.approach_r.z() * s.approach_r.z()); },
  };
}

}  // namespace

Family probe_pretravel_family() {
  return {
      .name = "probe_pretravel",
      .what = "the probe triggers earlier along its stylus than across it",
      .remedy = "a sphere touched from all sides at a fixed pose, or faces at tilts between 0 and 90 deg",
      .absurd = from_unit(50, Unit::um),
      .candidates =
          [](const CandidateScope& scope) {
            std::vector<EffectPtr> found;
            if (has_kind(scope, ReadingKind::contact)) found.push_back(make_effect(probe_pretravel("")));
            return found;
          },
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext&) -> EffectPtr {
        return make_effect(probe_pretravel(detail), json);
      },
  };
}

}  // namespace trunnion
