#include <algorithm>

#include "model/effects/artifact_effects.h"
#include "model/effects/families.h"
#include "model/effects/formula_effect.h"

namespace trunnion {
namespace {

constexpr std::size_t kMostMoments = 30;  // scanned for one body

/// A body that was knocked or slipped: from reading number `moment` on it stands moved by s in W, d = R s.
Formula artifact_slip(const std::string& label, double moment, const EffectContext& context) {
  if (label.empty()) refuse_detail("artifact_slip", label, "the label of an artifact, or \"all\",");
  Formula formula{
      .id = "artifact_slip:" + label,
      .origin = Origin::measurement,
      .depends_on = {"artifact", "order"},
      .shape = {{"moment", Unit::one, moment}},
      .shape_ranges = {{.low = 0, .high = 1e12, .whole = true}},
      .basis =
          [label, chain = context.chain](const Situation& s, const Eigen::VectorXd& shape) {
            return steps_in_w(*chain, s, concerns(s, label) && s.order >= shape[0] ? 1 : 0);
          },
  };
  for (const char* name : {"X", "Y", "Z"}) formula.parameters.push_back({name, Unit::um, 0, from_unit(500, Unit::um)});
  return formula;
}

/// First readings of each visit to a body (it was left, or the table moved, before), without the very first.
std::vector<double> visits(const CandidateScope& scope, std::string_view label) {
  std::vector<double> moments;
  const Situation* before = nullptr;
  for (const Situation& s : scope.readings) {
    const bool same_visit = before != nullptr && before->at == s.at && before->repeat == s.repeat &&
                            before->artifact == s.artifact && before->order + 1 == s.order;
    before = &s;
    if (concerns(s, label) && !(same_visit && label != kAllArtifacts) &&
        (label != kAllArtifacts || s.order_in_pose == 0))
      moments.push_back(s.order);
  }
  if (!moments.empty()) moments.erase(moments.begin());
  return moments;
}

std::vector<EffectPtr> slips(const CandidateScope& scope) {
  std::vector<EffectPtr> found;
  std::vector<std::string> labels = scope.artifacts;
  if (labels.size() != 1) labels.emplace_back(kAllArtifacts);
  for (const std::string& label : labels) {
    if (label.empty()) continue;
    const std::vector<double> moments = visits(scope, label);
    const std::size_t count = std::min(moments.size(), kMostMoments);
    for (std::size_t i = 0; i < count; ++i)
      found.push_back(make_effect(artifact_slip(label, moments[i * moments.size() / count], scope.context)));
  }
  return found;
}

}  // namespace

Family artifact_slip_family() {
  return {
      .name = "artifact_slip",
      .what = "a probed body moved on the table at one moment",
      .remedy = "the body's spots at the reference pose once more",
      .candidates = slips,
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext& context) -> EffectPtr {
        return make_effect(artifact_slip(detail, 0, context), json);
      },
  };
}

}  // namespace trunnion
