#include "compensation/controller.h"

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>

#include "compensation/controllers/controllers.h"
#include "compensation/limits.h"
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
      profile(m, questions,
              depends_on(d, std::string(1, m.tilt_letter()) + "_dir") || depends_on(d, "C_dir") ? Reversal::some
                                                                                                : Reversal::none),
      model_hash(model_fingerprint(d)) {
  volume.tool_length = options.tool_length;
}

const std::vector<Controller>& controllers() {
  static const std::vector<Controller> all = [] {
    std::vector<Controller> list = {linuxcnc(), sinumerik_840d(), isg_twincat(), heidenhain(), fanuc_30i(), aerotech()};
    for (Controller& controller : list) controller.questions.numbers.push_back(slope_limit());
    return list;
  }();
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

void refuse_unknown_keys(const Controller& controller, const Machine& machine) {
  const auto keys_of = [](const Controller& c) {
    std::vector<std::string_view> keys;
    for (const ProfileItem& item : c.questions.items) keys.emplace_back(item.key);
    for (const ProfileNumber& number : c.questions.numbers) keys.emplace_back(number.key);
    return keys;
  };
  std::set<std::string_view> known;
  for (const Controller& c : controllers())
    for (const std::string_view key : keys_of(c)) known.insert(key);
  for (const auto& [key, value] : machine.profile)
    if (key.find('.') == std::string::npos && !known.contains(key))
      throw ModelError("profile." + key + ": not known; the nearest that " + std::string(controller.name) +
                       " asks for is \"" + nearest_name(key, keys_of(controller)) + "\"");
}

std::map<char, long> axis_numbers(const CompensationTask& task) {
  std::map<char, long> numbers;
  for (const char letter : {'X', 'Y', 'Z', task.machine.tilt_letter(), 'C'}) {
    const long number = std::lround(task.profile.number(std::string("axis_number_") + letter));
    for (const auto& [other, taken] : numbers)
      if (taken == number)
        throw ModelError("profile.axis_number_" + std::string(1, letter) + ": " + std::to_string(number) + " is " +
                         other + "'s number, another is wanted");
    numbers[letter] = number;
  }
  return numbers;
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

std::string comment_header(const CompensationTask& task, std::string_view mark) {
  const std::string begin = std::string(mark) + " ";
  std::string text = begin + provenance(task) + "\n";
  if (!task.profile.load_ready()) text += begin + std::string(kNotLoadReady) + ": see COMMISSIONING.md\n";
  return text;
}

}  // namespace trunnion
