#include <charconv>
#include <cmath>

#include "model/effects/columns.h"
#include "model/effects/families.h"
#include "model/effects/formula_effect.h"
#include "model/effects/probe_effects.h"

namespace trunnion {
namespace {

/// Pretravel that goes k times round the stylus:  y = (1 - n_z^2) (a cos k phi + b sin k phi),  phi = atan2(n_y, n_x)
/// of the approach. It fades towards the stylus axis, where phi has no meaning.
Formula probe_lobing(const std::string& detail) {
  int lobes = 0;
  const char* last = detail.data() + detail.size();
  if (std::from_chars(detail.data(), last, lobes).ptr != last || lobes < 1 || lobes > 12)
    refuse_detail("probe_lobing", detail, "the lobes per turn, 1 to 12,");
  return {
      .id = "probe_lobing:" + std::to_string(lobes),
      .origin = Origin::measurement,
      .depends_on = {"nx", "ny", "nz"},
      .parameters = {{"cos", Unit::um}, {"sin", Unit::um}},
      .basis =
          [lobes](const Situation& s, const Eigen::VectorXd&) {
            const Eigen::Vector3d& n = s.approach_r;
            const double phase = lobes * std::atan2(n.y(), n.x()), lateral = 1 - n.z() * n.z();
            Matrix6Xd b(6, 2);
            b << along_approach(s, lateral * std::cos(phase)), along_approach(s, lateral * std::sin(phase));
            return b;
          },
  };
}

}  // namespace

Family probe_lobing_family() {
  return {
      .name = "probe_lobing",
      .what = "the probe triggers earlier in some directions than in others",
      .remedy = "the reference pose once more with the spindle at 180 or 60 deg, or a sphere touched all round",
      .absurd = from_unit(50, Unit::um),
      .candidates =
          [](const CandidateScope& scope) {
            std::vector<EffectPtr> found;
            if (!has_kind(scope, ReadingKind::contact)) return found;
            for (const char* lobes : {"1", "2", "3", "4"}) found.push_back(make_effect(probe_lobing(lobes)));
            return found;
          },
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext&) -> EffectPtr {
        return make_effect(probe_lobing(detail), json);
      },
  };
}

}  // namespace trunnion
