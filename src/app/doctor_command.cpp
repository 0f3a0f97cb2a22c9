#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/changed_inputs.h"
#include "app/command.h"
#include "app/readings_input.h"
#include "app/terminal.h"
#include "conventions/machine_checks.h"
#include "conventions/model_checks.h"
#include "conventions/reading_checks.h"
#include "conventions/sign_test.h"
#include "error.h"
#include "io/csv.h"
#include "io/machine_file.h"
#include "io/model_file.h"
#include "io/observation_file.h"
#include "io/output_file.h"
#include "io/probe_program.h"
#include "io/text_file.h"
#include "model/effects/rotary_error_map.h"
#include "planning/probing_plan.h"
#include "postproc/dialect.h"

namespace trunnion {
namespace doctor_cli {
namespace {

struct Options {
  std::string machine, observations, model, form, dialect, output;
  double tool_length_mm = 0;
};

/// A spreadsheet may have put separators behind a comment line.
void refuse_form_of_other_serial(const std::string& text, const std::string& path, const Machine& machine) {
  const std::size_t at = text.find(kFormSerial);
  if (at == std::string::npos) return;
  const std::size_t from = at + kFormSerial.size();
  const std::string found = text.substr(from, text.find_first_of("\r\n", from) - from);
  if (!found.starts_with(machine.serial) ||
      found.find_first_not_of(",;\t \"", machine.serial.size()) != std::string::npos)
    throw RefusalError(path + ": the form is of a machine with serial number \"" + found +
                       "\", the machine file says \"" + machine.serial + "\"");
}

std::vector<FilledStep> read_form(const std::string& path, const Machine& machine) {
  const std::string text = read_text(path);
  refuse_form_of_other_serial(text, path, machine);
  CsvReader csv(text, path);
  const std::string tilt = std::string(1, machine.tilt_letter()) + "_deg";
  std::array<std::size_t, 5> columns{};
  std::size_t k = 0;
  for (const std::string& name :
       {tilt, std::string("C_deg"), std::string("x_mm"), std::string("y_mm"), std::string("z_mm")}) {
    const auto found = csv.find(name);
    if (!found) throw InputError(path, csv.line(), "column " + name + " is missing");
    columns[k++] = *found;
  }
  std::vector<FilledStep> steps;
  std::vector<std::string_view> fields;
  while (csv.next(fields)) {
    std::array<double, 5> value{};
    for (std::size_t i = 0; i < 5; ++i) {
      if (trimmed(fields[columns[i]]).empty())
        throw InputError(path, csv.line(),
                         csv.header()[columns[i]] + ": left blank, what the control showed is wanted");
      value[i] = csv.number(fields[columns[i]], columns[i]);
    }
    steps.push_back({{Angle::degrees(value[0]), Angle::degrees(value[1])}, {value[2], value[3], value[4]}});
  }
  return steps;
}

/// Touches of two poses at which the model is told best: up to three spots at the reference pose, where it is largest,
/// and at the reference pose again. Empty where no spot can be reached at both.
ObservationSet two_poses(const Model& model, const Machine& machine, const std::vector<Spot>& spots) {
  const KinematicChain chain(machine);
  const RotaryErrorMap* map = model.rotary_map();
  if (map == nullptr) return {};
  const Range<Angle> tilts = map->surface().a_range();
  const std::vector<std::size_t> at_reference = reachable(machine, chain, spots, {});
  std::vector<std::size_t> best;
  IndexedPosition best_at;
  double largest = 0;
  for (int i = 0; i <= 6; ++i)
    for (int j = 0; j < 12; ++j) {
      const IndexedPosition at{tilts.low + i / 6.0 * (tilts.high - tilts.low), Angle::degrees(30.0 * j)};
      std::vector<std::pair<double, std::size_t>> sizes;
      const Eigen::Isometry3d r_from_w = chain.r_from_w(at);
      for (const std::size_t k : reachable(machine, chain, spots, at)) {
        if (!std::ranges::binary_search(at_reference, k)) continue;
        const Situation s{.at = at, .point_r_mm = r_from_w * spots[k].place_w_mm};
        try {
          sizes.emplace_back(std::abs((r_from_w.linear() * spots[k].outward_w).dot(deviation_mm(model, s))), k);
        } catch (const RangeError&) {
          break;  // what no measurement determines there
        }
      }
      std::ranges::sort(sizes, std::greater<>());
      if (sizes.empty() || sizes.front().first <= largest) continue;
      largest = sizes.front().first, best_at = at;
      best.clear();
      for (std::size_t k = 0; k < std::min<std::size_t>(3, sizes.size()); ++k) best.push_back(sizes[k].second);
    }
  if (best.empty()) return {};
  const std::vector<Visit> visits = {
      {.at = {}, .spots = best}, {.at = best_at, .spots = best}, {.at = {}, .spots = best}};
  return planned_observations(machine, spots, visits, {}, "two poses");
}

std::string dialect_of(const Options& o, const Machine& machine) {
  if (!o.dialect.empty()) return o.dialect;
  for (const std::string& name : dialect_names())
    if (!machine.controller.empty() && dialect(name).controller == machine.controller) return name;
  return "";
}

void write_tests(const Options& o, const Machine& machine, const std::optional<Model>& model,
                 const std::optional<ObservationSet>& readings, const std::vector<std::string>& inputs,
                 const Talk& talk) {
  OutputFolder folder(o.output, inputs);
  std::string written = "sign_test.csv";
  folder.add("sign_test.csv", sign_form(machine));
  if (const std::string name = dialect_of(o, machine); !name.empty()) {
    const std::string file = name == "heidenhain"  ? "sign_test.h"
                             : name == "sinumerik" ? "sign_test.mpf"
                             : name == "fanuc"     ? "sign_test.nc"
                                                   : "sign_test.ngc";
    folder.add(file, sign_program(machine, name));
    written += ", " + file;
  } else {
    folder.add("sign_test.DRAFT.nc", sign_program(machine, "plain"));
    written += ", sign_test.DRAFT.nc";
    talk.warn(
        "no dialect is known of this control: sign_test.DRAFT.nc has plain ISO words; read it before it is run, or "
        "command the stops of sign_test.csv by hand");
  }
  if (model) {
    const KinematicChain chain(machine);
    const std::vector<Spot> seen = readings ? spots_of(*readings, chain) : std::vector<Spot>{};
    const std::vector<Spot> spots = seen.empty() ? column_spots() : seen;
    const ObservationSet plan = two_poses(*model, machine, spots);
    if (plan.rows.empty()) {
      talk.warn("no spot can be touched both at the reference pose and elsewhere: the sign of the model is not tested");
    } else {
      folder.add("two_poses.csv", observations_text(plan, machine.tilt_letter()));
      written += ", two_poses.csv";
      if (!chain.has_rotary(Side::tool)) {
        folder.add("two_poses.ngc", linuxcnc_probe_program(plan, machine, {}, "two_poses.log"));
        written += ", two_poses.ngc";
      }
    }
  }
  folder.commit();
  talk.say("wrote " + o.output + "/" + written);
}

Paint paint_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::passed:
      return Paint::good;
    case Outcome::open:
      return Paint::faint;
    case Outcome::warning:
      return Paint::doubtful;
    case Outcome::failed:
      return Paint::bad;
  }
  return Paint::plain;
}

std::size_t count(const Checks& checks, Outcome outcome) {
  return static_cast<std::size_t>(std::ranges::count(checks, outcome, &Check::outcome));
}

std::string verdict(const Checks& checks) {
  const std::size_t failed = count(checks, Outcome::failed), warnings = count(checks, Outcome::warning);
  const auto many = [](std::size_t n, const char* one, const char* more) {
    return std::to_string(n) + " " + (n == 1 ? one : more);
  };
  if (failed > 0)
    return many(failed, "check", "checks") + " failed: load nothing on this machine before that is understood";
  if (warnings > 0) return "no check failed, " + many(warnings, "warning wants", "warnings want") + " a look";
  return "no check failed";
}

std::string summary(const Checks& checks) {
  constexpr std::size_t kWord = 9;
  std::string text = "Verdict: " + verdict(checks) + ".\n" + std::to_string(count(checks, Outcome::passed)) +
                     " passed, " + std::to_string(count(checks, Outcome::open)) + " open, " +
                     std::to_string(count(checks, Outcome::warning)) + " with a warning, " +
                     std::to_string(count(checks, Outcome::failed)) + " failed\n\n";
  for (const Outcome outcome : {Outcome::failed, Outcome::warning, Outcome::open, Outcome::passed})
    for (const Check& check : checks) {
      if (check.outcome != outcome) continue;
      const std::string word = outcome_text(outcome);
      text += painted(word, paint_of(outcome)) + std::string(kWord - word.size(), ' ') +
              wrapped(check.id + ": " + check.found, kWord) + "\n";
      if (!check.advice.empty()) text += std::string(kWord, ' ') + wrapped("-> " + check.advice, kWord + 3) + "\n";
    }
  return text;
}

nlohmann::json checks_json(const Checks& checks, const Machine& machine) {
  nlohmann::json list = nlohmann::json::array();
  for (const Check& check : checks) {
    std::string word = outcome_text(check.outcome);
    std::ranges::transform(word, word.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    list.push_back({{"id", check.id}, {"outcome", word}, {"found", check.found}, {"advice", check.advice}});
  }
  return {{"format", "trunnion-doctor"},
          {"version", 1},
          {"machine", {{"name", machine.name}, {"serial", machine.serial}}},
          {"verdict", verdict(checks)},
          {"failed", count(checks, Outcome::failed)},
          {"checks", std::move(list)}};
}

int run(const Options& o, const Talk& talk) {
  const Machine machine = read_machine(o.machine);
  std::vector<std::string> inputs = {o.machine};
  Checks checks = machine_checks(machine);
  const auto add = [&](Checks more) {
    for (Check& check : more) checks.push_back(std::move(check));
  };
  std::optional<Model> model;
  std::optional<ObservationSet> readings;
  if (!o.form.empty()) {
    inputs.push_back(o.form);
    std::erase_if(checks, [](const Check& check) { return check.id.starts_with("senses."); });  // now they are known
    add(sign_verdict(machine, read_form(o.form, machine), o.tool_length_mm));
  }
  if (!o.observations.empty()) {
    inputs.push_back(o.observations);
    readings = observations_input(o.observations, machine, talk);
    add(reading_checks(*readings, machine));
  }
  const bool usable = count(checks, Outcome::failed) == 0;
  if (!o.model.empty()) {
    inputs.push_back(o.model);
    model = read_model(o.model, machine);
    check_same_machine(*model, machine, o.model);
    for (const std::string& line : changed_inputs(*model, o.model, {o.machine})) talk.warn(line);
    add(model_checks(*model, machine));
    if (readings && usable &&
        std::ranges::none_of(readings->rows, [](const Observation& r) { return r.kind == ReadingKind::pose; }))
      checks.push_back(sign_check(*readings, *model, machine));
  }
  if (!o.output.empty()) write_tests(o, machine, model, readings, inputs, talk);
  talk.show(summary(checks));
  if (talk.json) std::printf("%s\n", checks_json(checks, machine).dump(1).c_str());
  return count(checks, Outcome::failed) == 0 ? 0 : 1;
}

}  // namespace
}  // namespace doctor_cli

Command doctor_command(CLI::App& program, const Talk& talk) {
  using namespace doctor_cli;
  auto o = std::make_shared<Options>();
  CLI::App* app = program.add_subcommand(
      "doctor", "Signs, units, zeros and frames, checked before anything is loaded on a machine");
  app->add_option("--machine", o->machine, "Machine file (TOML)")->required()->type_name("M.toml")->group("Input");
  app->add_option("--observations", o->observations, "Measurements (CSV)")->type_name("O.csv")->group("Input");
  app->add_option("--model", o->model, "Model whose size, and with measurements whose sign, is checked")
      ->type_name("model.json")
      ->group("Input");
  CLI::Option* form = app->add_option("--form", o->form, "The form of the sign test, filled in (CSV)")
                          ->type_name("sign_test.csv")
                          ->group("Input");
  app->add_option("--tool-length", o->tool_length_mm, "Of the tool that touched the mark, where an axis carries it, mm")
      ->check(CLI::Range(0.0, 2000.0))
      ->needs(form)
      ->group("Input");
  app->add_option(
         "-o,--output", o->output,
         "Folder for the sign test, a short NC program and its form; with a model, for two poses to be touched")
      ->type_name("DIR")
      ->group("Output");
  app->add_option("--dialect", o->dialect, "Of that program; default: the machine's control")
      ->check(CLI::IsMember(dialect_names()))
      ->group("Output");
  app->footer(
      "Exit status 1 where a check failed.\nExamples:\n  trunnion doctor --machine machine.toml -o sign_test\n"
      "  trunnion doctor --machine machine.toml --form sign_test/sign_test.csv\n"
      "  trunnion doctor --machine machine.toml --observations calibration.csv --model model.json");
  return {app, [o, &talk] { return run(*o, talk); }};
}

}  // namespace trunnion
