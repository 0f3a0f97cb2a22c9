#include "model/effects/artifact_effects.h"
#include "model/effects/families.h"
#include "model/effects/formula_effect.h"

namespace trunnion {
namespace {

/// A slender body on a tilted table bends under its own weight: it moves in W by k times the part of gravity across its
/// axis, (g_x, g_y, 0) with the unit vector g = R^T (0, 0, -1). Nothing at A = 0.
Formula artifact_flex(const std::string& label, const EffectContext& context) {
  if (label.empty()) refuse_detail("artifact_flex", label, "the label of an artifact");
  return {
      .id = "artifact_flex:" + label,
      .origin = Origin::measurement,
      .depends_on = {"artifact", std::string(1, context.tilt_letter) + "_deg", "C_deg"},
      .parameters = {{"bending", Unit::um}},
      .basis =
          [label, chain = context.chain](const Situation& s, const Eigen::VectorXd&) {
            Matrix6Xd b = Matrix6Xd::Zero(6, 1);
            if (!concerns(s, label)) return b;
            const Eigen::Matrix3d r = chain->r_from_w(s.at).linear();
            const Eigen::Vector3d down_w = -r.row(2).transpose();
            b.topRows<3>() = r * Eigen::Vector3d(down_w.x(), down_w.y(), 0);
            return b;
          },
  };
}

}  // namespace

Family artifact_flex_family() {
  return {
      .name = "artifact_flex",
      .what = "a slender probed body bends under its own weight as the table tilts",
      .remedy = "shorter bodies, or a short one beside the tall ones",
      .absurd = from_unit(100, Unit::um),
      .candidates =
          [](const CandidateScope& scope) {
            std::vector<EffectPtr> found;
            if (scope.artifacts.size() > 1)
              for (const std::string& label : scope.artifacts)
                if (!label.empty()) found.push_back(make_effect(artifact_flex(label, scope.context)));
            return found;
          },
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext& context) -> EffectPtr {
        return make_effect(artifact_flex(detail, context), json);
      },
  };
}

}  // namespace trunnion
