#include "testpiece/told_errors.h"

namespace trunnion {
namespace {

using nlohmann::json;
using testing::VirtualMachine;

json entry(const std::string& id, const std::map<std::string, std::pair<double, std::string>>& parameters,
           const json& keys = json::object()) {
  json j = keys;
  j["id"] = id;
  for (const auto& [name, quantity] : parameters)
    j["parameters"][name] = {{"value", quantity.first}, {"unit", quantity.second}};
  return j;
}

json with_shape(json j, const std::string& name, double value, const std::string& unit) {
  j["shape"][name] = {{"value", value}, {"unit", unit}};
  return j;
}

}  // namespace

std::vector<ToldError> told_errors() {
  const testing::AxisErrors per_kelvin = testing::um_urad(2, -3, 4, 0, 0, 0);
  return {
      {entry("linear_scale:X", {{"EXX", {60, "um/m"}}}), [](VirtualMachine& m) { add_linear_scale(m, 'X', 60e-6); }},
      {entry("squareness:YZ", {{"EA0Z", {80, "urad"}}}), [](VirtualMachine& m) { add_squareness(m, "YZ", 80e-6); }},
      {entry("straightness:EYX", {{"quadratic", {900, "um/m^2"}}, {"cubic", {0, "um/m^3"}}}),
       [](VirtualMachine& m) { add_straightness(m, "EYX", [](double x) { return 900e-9 * x * x; }); }},
      {entry("linear_angular:EAY", {{"EAY", {400, "urad/m"}}}),
       [](VirtualMachine& m) { add_table_angular(m, "EAY", [](double y) { return 400e-9 * y; }); }},
      {entry("linear_angular:EAZ", {{"EAZ", {400, "urad/m"}}}),
       [](VirtualMachine& m) { add_tool_angular(m, "EAZ", [](double z) { return 400e-9 * z; }); }},
      {with_shape(entry("linear_periodic:Y", {{"cos", {3, "um"}}, {"sin", {0, "um"}}}), "period", 12.5, "mm"),
       [](VirtualMachine& m) { add_linear_periodic(m, 'Y', 3e-3, 12.5, 0); }},
      {entry("linear_backlash:Y", {{"reversal", {6, "um"}}}),
       [](VirtualMachine& m) { add_linear_backlash(m, 'Y', 6e-3); }},
      {entry("backlash:A", {{"reversal", {-80, "urad"}}}),
       [](VirtualMachine& m) { add_rotary_backlash(m, 'A', 80e-6); }},
      {entry("backlash:C", {{"reversal", {-80, "urad"}}}),
       [](VirtualMachine& m) { add_rotary_backlash(m, 'C', 80e-6); }},
      {entry("cyclic_error:C:12", {{"cos", {60, "urad"}}, {"sin", {-40, "urad"}}}),
       [](VirtualMachine& m) { add_cyclic_error(m, 'C', 12, 60e-6, -40e-6); }},
      {entry("brake_clamp:A", {{"step", {80, "urad"}}}, {{"column", "A_clamped"}}),
       [](VirtualMachine& m) { add_brake_clamp(m, 'A', "A_clamped", 80e-6); }},
      {entry("payload_sag", {{"sin", {4, "urad/kg"}}, {"cos", {0, "urad/kg"}}, {"seat", {0, "urad/kg"}}},
             {{"column", "load_kg"}}),
       [](VirtualMachine& m) { add_payload_sag(m, "load_kg", 0, 4e-6); }},
      {with_shape(entry("thermal_drift", {{"X", {8, "um"}}, {"Y", {-6, "um"}}, {"Z", {9, "um"}}}), "time_constant", 20,
                  "s"),
       [](VirtualMachine& m) { add_thermal_drift(m, testing::um_urad(8, -6, 9, 0, 0, 0), 20); }},
      {entry("temperature", {{"X", {2, "um/K"}}, {"Y", {-3, "um/K"}}, {"Z", {4, "um/K"}}}),
       [=](VirtualMachine& m) { add_temperature(m, per_kelvin); }},
  };
}

}  // namespace trunnion
