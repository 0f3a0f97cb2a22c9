#include "app/prior_map.h"

#include <nlohmann/json.hpp>

#include "error.h"

namespace trunnion {
namespace {

double drift(std::optional<double> told, const Model& earlier, const char* unit) {
  if (told) return *told;
  if (earlier.fit && earlier.fit->is_object() && earlier.fit->contains("drift") &&
      (*earlier.fit)["drift"].contains(unit) && (*earlier.fit)["drift"][unit].is_number())
    return (*earlier.fit)["drift"][unit].get<double>();
  throw UsageError(std::string("--drift-") + unit +
                   ": wanted, since the prior does not say how far the machine may have moved (trunnion history prior "
                   "writes one that does)");
}

}  // namespace

PriorMap prior_map(const Model& model, const std::string& name, std::optional<double> drift_um,
                   std::optional<double> drift_urad) {
  PriorMap prior;
  for (const EffectPtr& effect : model.effects)
    if (effect->origin() == Origin::machine && effect->id() != "rotary_error_map")
      prior.notes.push_back(name + ": " + effect->id() + " of the prior is not used, only its map is");
  prior.earlier.drift = {Length::micrometres(drift(drift_um, model, "um")),
                         Angle::microradians(drift(drift_urad, model, "urad"))};
  for (const EffectPtr& effect : model.effects)
    if (auto map = std::dynamic_pointer_cast<const RotaryErrorMap>(effect)) prior.earlier.map = std::move(map);
  if (!prior.earlier.map) throw InputError(name, "a rotary_error_map is wanted as the prior");
  return prior;
}

}  // namespace trunnion
