#include "compensation/controller.h"

#include <cstdint>
#include <nlohmann/json.hpp>

#include "compensation/controllers/controllers.h"
#include "error.h"
#include "units/nearest_name.h"

namespace trunnion {

CompensationTask::CompensationTask(const Machine& m, const Model& d, const TableOptions& o,
                                   const ProfileQuestions& questions)
    : machine(m),
      model(d),
      chain(m),
      volume(working_volume(m, d)),
      options(o),
      profile(m, questions),
      model_hash(model_fingerprint(d)) {
  volume.tool_length = options.tool_length;
}

const std::vector<Controller>& controllers() {
  static const std::vector<Controller> all = {linuxcnc(), sinumerik_840d(), isg_twincat(), heidenhain(), fanuc_30i(), aerotech()};
  return all;
}

const Controller& controller_named(const std::string& name) {
  std::vector<std::string_view> names;
  for (const Controller& controller : controllers()) {
    if (controller.name == name) return controller;
    names.push_back(controller.name);
  }
  throw UsageError("controller \"" + name + "\": not known; the nearest is \"" + nearest_name(name, names) + "\"");
}

std::string model_fingerprint(const Model& model) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const EffectPtr& effect : model.effects) {
    if (!effect->is_compensated()) continue;
    for (const char letter : effect->to_json().dump()) {
      hash ^= static_cast<unsigned char>(letter);
      hash *= 0x100000001b3U;
    }
  }
  std::string text(16, '0');
  for (std::size_t i = 16; i-- > 0; hash >>= 4U) text[i] = "0123456789abcdef"[hash & 15U];
  return text;
}

std::string provenance(const CompensationTask& task) {
  std::string text = task.machine.name + ", serial " + task.machine.serial + ", model " + task.model_hash;
  for (char& letter : text)
    if (letter == '\n' || letter == '\r' || letter == ';' || letter == '*') letter = ' ';
  return task.options.date.empty() ? text : text + ", " + task.options.date;
}

}  // namespace trunnion
