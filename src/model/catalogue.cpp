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

EffectPtr read_effect(const nlohmann::json& entry, const EffectContext& context) {
  if (!entry.is_object() || !entry.contains("id") || !entry["id"].is_string())
    throw ModelError("effects: every entry needs an \"id\"");
  const std::string id = entry["id"];
  const std::size_t colon = id.find(':');
  EffectPtr effect = family_of(id).read(colon == std::string::npos ? "" : id.substr(colon + 1), entry, context);
  if (entry.contains("origin")) {
    const std::string_view wanted = effect->origin() == Origin::machine ? "machine" : "measurement";
    if (entry["origin"] != wanted)
      throw ModelError("effect " + id + ": origin: " + entry["origin"].dump() + " found, \"" + std::string(wanted) +
                       "\" is right");
  }
  if (entry.contains("suspended")) {
    if (!entry["suspended"].is_boolean())
      throw ModelError("effect " + id + ": suspended: " + entry["suspended"].dump() +
                       " found, true or false is wanted");
    if (entry["suspended"].get<bool>()) return effect->suspended();
  }
  return effect;
}

}  // namespace trunnion
