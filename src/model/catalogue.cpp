#include "model/catalogue.h"

#include <nlohmann/json.hpp>

#include "error.h"
#include "model/effects/families.h"
#include "units/nearest_name.h"

namespace trunnion {

const std::vector<Family>& catalogue() {
  static const std::vector<Family> families = {
      rotary_error_map_family(), location_errors_family(),    linear_scale_family(),   backlash_family(),
      squareness_family(),       straightness_family(),       linear_angular_family(), linear_periodic_family(),
      linear_backlash_family(),  cyclic_error_family(),       brake_clamp_family(),    payload_sag_family(),
      thermal_drift_family(),    temperature_family(),        probe_lobing_family(),   probe_pretravel_family(),
      probe_settling_family(),   artifact_expansion_family(), artifact_slip_family(),  artifact_creep_family(),
      artifact_flex_family(),    pass_shift_family(),         smooth_family(),
  };
  return families;
}

const Family& family_of(const std::string& id) {
  const std::string name = id.substr(0, id.find(':'));
  std::vector<std::string_view> names;
  for (const Family& family : catalogue()) {
    if (family.name == name) return family;
    names.push_back(family.name);
  }
  throw ModelError("effect \"" + id + "\": no such family; the nearest is \"" + nearest_name(name, names) + "\"");
}

EffectPtr read_effect(const nlohmann::json& json, const EffectContext& context) {
  if (!json.is_object() || !json.contains("id") || !json["id"].is_string())
    throw ModelError("effects: every entry needs an \"id\"");
  const std::string id = json["id"];
  const std::size_t colon = id.find(':');
  EffectPtr effect = family_of(id).read(colon == std::string::npos ? "" : id.substr(colon + 1), json, context);
  if (json.contains("origin")) {
    const std::string_view wanted = effect->origin() == Origin::machine ? "machine" : "measurement";
    if (json["origin"] != wanted)
      throw ModelError("effect " + id + ": origin: " + json["origin"].dump() + " found, \"" + std::string(wanted) +
                       "\" is right");
  }
  if (json.contains("suspended")) {
    if (!json["suspended"].is_boolean())
      throw ModelError("effect " + id + ": suspended: " + json["suspended"].dump() + " found, true or false is wanted");
    if (json["suspended"].get<bool>()) return effect->suspended();
  }
  return effect;
}

}  // namespace trunnion
