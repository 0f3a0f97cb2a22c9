#include "io/model_file.h"

#include <nlohmann/json.hpp>
#include <set>

#include "error.h"
#include "io/json_text.h"
#include "io/text_file.h"
#include "units/nearest_name.h"

namespace trunnion {

using nlohmann::json;

namespace {

void check_keys(const json& object, const std::vector<std::string>& known, const std::string& where) {
  for (const auto& [key, value] : object.items()) {
    (void)value;
    if (std::ranges::find(known, key) == known.end())
      throw ModelError(where + "\"" + key + "\" is not a key here; the nearest is \"" + nearest_name(key, known) +
                       "\"");
  }
}

std::string text_of(const json& object, const char* key, const std::string& where) {
  if (!object.contains(key) || !object[key].is_string()) throw ModelError(where + key + ": a text is wanted");
  return object[key].get<std::string>();
}

}  // namespace

Model parse_model(std::string_view text, const std::string& name, const Machine& machine) {
  const json document = parse_json(text, name);
  try {
    if (!document.is_object()) throw ModelError("an object is wanted");
    check_keys(document, {"format", "version", "machine", "reference_pose_deg", "effects", "fit"}, "");
    if (const std::string format = text_of(document, "format", ""); format != "trunnion-model")
      throw ModelError("format: \"" + format + "\" found, \"trunnion-model\" is wanted");
    if (!document.contains("version") || document["version"] != 1)
      throw ModelError("version: " + (document.contains("version") ? document["version"].dump() : "nothing") +
                       " found, this program reads version 1");
    Model model;
    if (!document.contains("machine") || !document["machine"].is_object())
      throw ModelError("machine: an object with name, serial and structure is wanted");
    const json& identity = document["machine"];
    check_keys(identity, {"name", "serial", "structure"}, "machine: ");
    model.machine = {text_of(identity, "name", "machine."), text_of(identity, "serial", "machine."),
                     text_of(identity, "structure", "machine.")};
    if (document.contains("reference_pose_deg")) {
      const json& reference = document["reference_pose_deg"];
      if (!reference.is_object()) throw ModelError("reference_pose_deg: an object is wanted");
      for (const auto& [axis, value] : reference.items())
        if (value != 0)
          throw ModelError("reference_pose_deg." + axis + ": " + value.dump() +
                           " found, this program holds errors relative to 0");
    }
    if (!document.contains("effects") || !document["effects"].is_array()) throw ModelError("effects: a list is wanted");
    check_same_machine(model, machine, name);
    const EffectContext context = effect_context(machine);
    std::set<std::string> ids;
    for (const json& entry : document["effects"]) {
      model.effects.push_back(read_effect(entry, context));
      if (!ids.insert(model.effects.back()->id()).second)
        throw ModelError("effect " + model.effects.back()->id() + " occurs twice");
    }
    if (document.contains("fit")) model.fit = std::make_shared<json>(document["fit"]);
    return model;
  } catch (const ModelError& e) {
    const std::string what = e.what();
    throw InputError(what.starts_with(name) ? what : name + ": " + what);
  } catch (const json::exception& e) {
    throw InputError(name, std::string("not a model: ") + e.what());
  }
}

Model read_model(const std::string& path, const Machine& machine) {
  return parse_model(read_text(path, kLargestJson_bytes), path, machine);
}

std::string model_text(const Model& model) {
  json document;
  document["format"] = "trunnion-model";
  document["version"] = 1;
  document["machine"] = {
      {"name", model.machine.name}, {"serial", model.machine.serial}, {"structure", model.machine.structure}};
  const Structure structure = parse_structure(model.machine.structure);
  bool tilts_by_a = false;
  for (const Joint& joint : structure.joints) tilts_by_a = tilts_by_a || joint.letter == 'A';
  document["reference_pose_deg"] = {{tilts_by_a ? "A" : "B", 0}, {"C", 0}};
  document["effects"] = json::array();
  for (const EffectPtr& effect : model.effects) document["effects"].push_back(effect->to_json());
  if (model.fit) document["fit"] = *model.fit;
  return json_text(document);
}

void check_same_machine(const Model& model, const Machine& machine, const std::string& name) {
  const auto refuse = [&](const char* what, const std::string& found, const std::string& wanted) {
    return name + ": the model is of a machine with " + what + " \"" + found + "\", the machine file says \"" + wanted +
           "\"";
  };
  if (model.machine.serial != machine.serial)
    throw RefusalError(refuse("serial number", model.machine.serial, machine.serial));
  if (model.machine.name != machine.name) throw RefusalError(refuse("the name", model.machine.name, machine.name));
  if (parse_structure(model.machine.structure).joints != machine.structure.joints)
    throw ModelError(refuse("structure", model.machine.structure, machine.structure.code));
}

}  // namespace trunnion
