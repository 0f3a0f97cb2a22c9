#include "model/model.h"

#include <algorithm>

#include "model/effects/rotary_error_map.h"

namespace trunnion {

const RotaryErrorMap* Model::rotary_map() const {
  for (const EffectPtr& effect : effects)
    if (const auto* map = dynamic_cast<const RotaryErrorMap*>(effect.get())) return map;
  return nullptr;
}

bool Model::has_uncertainty() const {
  const auto machine_effect_without = [](const EffectPtr& e) {
    return e->is_compensated() && !e->parameters().empty() && e->covariance().size() == 0;
  };
  const RotaryErrorMap* map = rotary_map();
  return (map == nullptr || map->has_uncertainty()) && std::ranges::none_of(effects, machine_effect_without) &&
         !effects.empty();
}

EffectContext effect_context(const Machine& machine) {
  return {std::make_shared<KinematicChain>(machine), machine.tilt_letter(), machine.structure};
}

PoseError table_error(const Model& model, const Situation& situation) {
  PoseError sum;
  for (const EffectPtr& effect : model.effects)
    if (effect->is_compensated() && effect->moves_table()) sum += effect->at(situation);
  return sum;
}

PoseError relative_error(const Model& model, const Situation& situation) {
  PoseError sum;
  for (const EffectPtr& effect : model.effects)
    if (effect->is_compensated()) sum += effect->at(situation);
  return sum;
}

Eigen::Vector3d deviation_mm(const Model& model, const Situation& situation) {
  return displacement_mm(relative_error(model, situation), situation.point_r_mm);
}

Eigen::Matrix3d deviation_covariance_mm2(const Model& model, const Situation& situation) {
  Matrix6d sum = Matrix6d::Zero();
  for (const EffectPtr& effect : model.effects)
    if (effect->is_compensated()) sum += effect->covariance_at(situation);
  const Eigen::Matrix<double, 3, 6> j = displacement_jacobian(situation.point_r_mm);
  return j * sum * j.transpose();
}

std::vector<std::string> needed_covariates(const Model& model) {
  static const std::vector<std::string> given = {"A_deg", "B_deg", "C_deg", "x_mm", "y_mm", "z_mm", "nx", "ny", "nz"};
  std::vector<std::string> needed;
  for (const EffectPtr& effect : model.effects) {
    if (!effect->is_compensated()) continue;
    for (const std::string& column : effect->depends_on())
      if (std::ranges::find(given, column) == given.end() && std::ranges::find(needed, column) == needed.end())
        needed.push_back(column);
  }
  return needed;
}

}  // namespace trunnion
