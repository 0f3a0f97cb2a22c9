#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/changed_inputs.h"
#include "app/command.h"
#include "app/history_text.h"
#include "app/progress.h"
#include "error.h"
#include "history/date.h"
#include "io/json_text.h"
#include "io/limits_file.h"
#include "io/machine_file.h"
#include "io/model_file.h"
#include "io/output_file.h"
#include "io/sha256.h"
#include "io/text_file.h"
#include "units/nearest_name.h"
#include "units/number_text.h"

namespace trunnion {
namespace history_cli {
namespace {

struct Options {
  std::string store, serial, machine, model, date, closure, note, limits, output;
  std::vector<std::string> data;
  std::int64_t id = 0, other = 0;
};

CalibrationStore open_store(const Options& o, OpenFor purpose) {
  return CalibrationStore(open_database(o.store, purpose));
}

std::string wanted_date(const std::string& text) {
  if (const auto date = normal_date(text)) return *date;
  throw UsageError("--date: \"" + text + "\" found, 2026-03-01 or 2026-03-01T14:30:00Z (UTC) is wanted");
}

/// Throws InputError for a data file that is not the one that the model was made from.
void check_data(const Options& o, const std::vector<std::pair<std::string, std::string>>& inputs) {
  for (const std::string& path : o.data) {
    const std::string digits = sha256_hex(read_text(path)), name = path.substr(path.find_last_of('/') + 1);
    const auto recorded = std::ranges::find(inputs, name, &std::pair<std::string, std::string>::first);
    if (recorded == inputs.end())
      throw InputError(path, o.model + " does not say that it was made from a file of this name");
    if (recorded->second != digits)
      throw InputError(path, "its SHA-256 is " + digits + ", " + o.model + " was made from " + recorded->second +
                                 ": the file was changed since");
  }
}

std::string closure_text(const Options& o, const Machine& machine) {
  const std::string text = read_text(o.closure);
  const nlohmann::json closure = parse_json(text, o.closure);
  if (!closure.is_object() || closure.value("format", nlohmann::json()) != "trunnion-closure")
    throw InputError(o.closure, "the closure.json of trunnion close is wanted");
  if (closure.contains("machine") && closure["machine"].value("serial", "") != machine.serial)
    throw RefusalError(o.closure + ": the closure is of serial number " + closure["machine"]["serial"].dump() +
                       ", the machine file says \"" + machine.serial + "\"");
  return text;
}

int add(const Options& o, const Talk& talk) {
  Calibration c{.taken = wanted_date(o.date), .note = o.note};
  c.machine_file = read_text(o.machine);
  const Machine machine = parse_machine(c.machine_file, o.machine);
  c.model = read_text(o.model);
  const Model model = parse_model(c.model, o.model, machine);
  for (const std::string& line : changed_inputs(model, o.model, {o.machine})) talk.warn(line);
  c.machine = model.machine;
  c.model_sha256 = sha256_hex(c.model);
  if (model.fit && model.fit->is_object() && model.fit->contains("inputs_sha256") &&
      (*model.fit)["inputs_sha256"].is_object())
    for (const auto& [name, digits] : (*model.fit)["inputs_sha256"].items())
      if (digits.is_string()) c.inputs.emplace_back(name, digits.get<std::string>());
  check_data(o, c.inputs);
  if (!o.closure.empty()) c.closure = closure_text(o, machine);
  const CalibrationStore::Added added = open_store(o, OpenFor::adding).add(c);
  c.id = added.id;
  if (talk.json) {
    nlohmann::json j = calibration_json(c);
    j["stood_already"] = added.stood_already;
    std::fputs(json_text(j).c_str(), stdout);
  }
  talk.show("calibration " + std::to_string(added.id) + ": serial " + c.machine.serial + ", " + short_date(c.taken) +
            (added.stood_already ? ", stood here already\n" : "\n"));
  return 0;
}

int list(const Options& o, const Talk& talk) {
  const std::vector<Calibration> all =
      open_store(o, OpenFor::reading).list(o.serial.empty() ? std::nullopt : std::optional(o.serial));
  nlohmann::json j = nlohmann::json::array();
  for (const Calibration& c : all) j.push_back(calibration_json(c));
  if (talk.json) std::fputs(json_text(j).c_str(), stdout);
  talk.show(calibration_table(all));
  return 0;
}

int show(const Options& o, const Talk& talk) {
  const Calibration c = intact(open_store(o, OpenFor::reading), o.id);
  if (!o.output.empty()) {
    write_whole(o.output, c.model, {o.store});
    talk.say("wrote " + o.output);
  }
  if (o.output == "-") return 0;
  if (talk.json) std::fputs(json_text(calibration_json(c)).c_str(), stdout);
  talk.show(calibration_text(c));
  return 0;
}

MachineHistory history_of(const Options& o, const Talk& talk) {
  MachineHistory h = machine_history(calibrations_of(open_store(o, OpenFor::reading), o.serial));
  for (const std::string& note : h.notes) talk.warn(note);
  if (h.series.functions.empty())
    throw InputError(o.store, "no positions of A and C that the maps of these calibrations share");
  return h;
}

int compare(const Options& o, const Talk& talk) {
  const CalibrationStore store = open_store(o, OpenFor::reading);
  std::vector<Calibration> both = {intact(store, o.id), intact(store, o.other)};
  if (both[0].machine.serial != both[1].machine.serial)
    throw RefusalError("calibration " + std::to_string(o.id) + " is of serial number \"" + both[0].machine.serial +
                       "\", " + std::to_string(o.other) + " of \"" + both[1].machine.serial + "\"");
  const MachineHistory h = machine_history(std::move(both));
  for (const std::string& note : h.notes) talk.warn(note);
  if (h.models.size() < 2 || h.series.functions.empty() || !h.series.left_out.empty())
    throw InputError(store.name(), "these two cannot be compared: two maps with standard uncertainties, made from " +
                                       std::string("different readings, are wanted"));
  if (talk.json) std::fputs(json_text(comparison_json(h)).c_str(), stdout);
  talk.show(comparison_text(h));
  return 0;
}

/// Throws InputError for a limit of something that no calibration has.
void check_limits(const AlarmLimits& limits, const SeriesSet& set, const std::string& file) {
  std::vector<std::string> names;
  for (const auto* kind : {&set.locations, &set.functions, &set.parameters})
    for (const ErrorSeries& series : *kind) names.push_back(series.name);
  for (const auto* table : {&limits.value, &limits.change})
    for (const auto& [name, limit] : *table)
      if (std::ranges::find(names, name) == names.end() && name.find(':') == std::string::npos)
        throw InputError(file,
                         "\"" + name + "\" is no error of this history; the nearest is " + nearest_name(name, names));
}

int trend(const Options& o, const Talk& talk) {
  const MachineHistory h = history_of(o, talk);
  const char tilt = h.machine.tilt_letter();
  std::vector<Alarm> alarms;
  if (!o.limits.empty()) {
    const AlarmLimits limits = read_limits(o.limits);
    check_limits(limits, h.series, o.limits);
    alarms = find_alarms(h.series, limits.value, limits.change);
  }
  if (!o.output.empty()) {
    write_whole(o.output, trend_csv(h), {o.store, o.limits});
    talk.say("wrote " + o.output);
  }
  if (talk.json) {
    nlohmann::json j = {{"format", "trunnion-trend"}, {"version", 1}, {"notes", h.notes}};
    j["machine"] = {{"name", h.machine.name}, {"serial", h.machine.serial}};
    j["calibrations"] = nlohmann::json::array();
    for (const Calibration& c : h.calibrations) j["calibrations"].push_back({{"id", c.id}, {"taken", c.taken}});
    j["alarms"] = nlohmann::json::array();
    for (const Alarm& alarm : alarms) j["alarms"].push_back(alarm_json(alarm, tilt));
    std::fputs(json_text(j).c_str(), stdout);
  }
  if (o.output != "-") talk.show(trend_text(h));
  for (const Alarm& alarm : alarms) std::fprintf(stderr, "alarm: %s\n", alarm_text(alarm, tilt).c_str());
  return alarms.empty() ? 0 : 1;
}

int drift(const Options& o, const Talk& talk) {
  const MachineHistory h = history_of(o, talk);
  if (h.models.size() < 2) throw InputError(o.store, "two or more independent calibrations are wanted");
  const double level = kTold / (1 + static_cast<double>(h.series.parameters.size()));
  CourseFinding course;
  std::vector<CourseFinding> parameters;
  {
    const Progress progress(talk, "search for changes in " + std::to_string(h.models.size()) + " calibrations");
    course = find_changes(h.series.poses, h.years, level);
    for (const ErrorSeries& series : h.series.parameters)
      parameters.push_back(find_changes(single_problem(series), h.years, level));
  }
  const nlohmann::json j = drift_json(h, course, parameters);
  if (!o.output.empty()) {
    write_whole(o.output, json_text(j), {o.store});
    talk.say("wrote " + o.output);
  }
  if (o.output == "-") return 0;
  if (talk.json) std::fputs(json_text(j).c_str(), stdout);
  talk.show(drift_text(h, course, parameters));
  return 0;
}

/// What the location errors of one unit may have wandered by over `years`: no more than history contradicts.
double wandered(const MachineHistory& h, Unit unit, double years) {
  std::vector<ErrorSeries> alike;
  for (const ErrorSeries& series : h.series.locations)
    if (series.unit == unit) alike.push_back(series);
  return to_unit(wandering_rate(alike, h.years).at_most, unit) * std::sqrt(years);
}

int prior(const Options& o, const Talk& talk) {
  const MachineHistory h = history_of(o, talk);
  if (h.models.size() < 2)
    throw InputError(o.store, "two or more independent calibrations are wanted, to tell how fast the machine wanders");
  const std::string date = wanted_date(o.date);
  const double years = days_of(date) / kDaysPerYear - h.years.back();
  if (years < 0)
    throw UsageError("--date: " + short_date(date) + " is before the last calibration, " +
                     short_date(h.calibrations.back().taken));
  const double um = wandered(h, Unit::um, years), urad = wandered(h, Unit::urad, years);
  Model model = h.models.back().model;
  model.fit = std::make_shared<nlohmann::json>(nlohmann::json{{"method", "carried on from a history"},
                                                              {"calibration", calibration_json(h.calibrations.back())},
                                                              {"until", date},
                                                              {"drift", {{"um", um}, {"urad", urad}}}});
  write_whole(o.output, model_text(model), {o.store});
  const std::string text = "calibration " + std::to_string(h.calibrations.back().id) + " of " +
                           short_date(h.calibrations.back().taken) +
                           formatted(", %.0f days before ", years * kDaysPerYear) + short_date(date) +
                           formatted(": errors may have moved by %.2g um", um) +
                           formatted(" and %.2g urad (1 sigma, not contradicted at 10 %%)\n", urad);
  if (o.output != "-") {
    if (talk.json) std::fputs(json_text((*model.fit)).c_str(), stdout);
    talk.show(text);
    talk.say("wrote " + o.output);
  }
  return 0;
}

/// A command of `history`, with the options that all of them have.
CLI::App* action(CLI::App& history, const std::string& name, const std::string& what, Options& o) {
  CLI::App* app = history.add_subcommand(name, what);
  app->add_option("--store", o.store, "The history: an SQLite file, or postgresql://…")
      ->required()
      ->type_name("STORE")
      ->group("Input");
  return app;
}

/// The machine, for commands that are about one of several.
void add_serial(CLI::App* app, Options& o) {
  app->add_option("--serial", o.serial, "The machine's serial number, where the store holds several")
      ->type_name("TEXT")
      ->group("Input");
}

}  // namespace
}  // namespace history_cli

Command history_command(CLI::App& program, const Talk& talk) {
  using namespace history_cli;
  auto o = std::make_shared<Options>();
  CLI::App* app = program.add_subcommand("history", "Calibrations kept over time: list, compare, trend, drift");
  app->require_subcommand(1);
  auto run = std::make_shared<Run>();
  const auto chosen = [run](CLI::App* sub, int (*act)(const Options&, const Talk&), std::shared_ptr<Options> options,
                            const Talk& to) {
    using namespace history_cli;
    sub->callback([=, &to] { *run = [=, &to] { return act(*options, to); }; });
  };

  CLI::App* sub = action(*app, "add", "Keep a model with what it was made from; the file is made if missing", *o);
  sub->add_option("--machine", o->machine, "Machine file (TOML)")->required()->type_name("M.toml")->group("Input");
  sub->add_option("--model", o->model, "Model (JSON)")->required()->type_name("model.json")->group("Input");
  sub->add_option("--date", o->date, "When the readings were taken: 2026-03-01 or 2026-03-01T14:30:00Z")
      ->required()
      ->type_name("DATE")
      ->group("Input");
  sub->add_option("--closure", o->closure, "closure.json of the same calibration")->type_name("C.json")->group("Input");
  sub->add_option("--data", o->data, "Files to check against the hashes in the model")
      ->type_name("FILE")
      ->group("Input");
  sub->add_option("--note", o->note, "A line of text to keep with it")->type_name("TEXT")->group("Input");
  sub->footer(
      "Example:\n"
      "  trunnion history add --store shop.db --machine machine.toml --model model.json --date 2026-03-01");
  chosen(sub, add, o, talk);

  sub = action(*app, "list", "What is kept, by serial number and date", *o);
  add_serial(sub, *o);
  sub->footer("Example:\n  trunnion history list --store shop.db");
  chosen(sub, list, o, talk);

  sub = action(*app, "show", "One calibration; -o writes its model as it was kept", *o);
  sub->add_option("id", o->id, "Number of the calibration")->required()->type_name("ID")->group("Input");
  sub->add_option("-o,--output", o->output, "Model to write (JSON)")->type_name("model.json")->group("Output");
  sub->footer("Example:\n  trunnion history show --store shop.db 3 -o model.json");
  chosen(sub, show, o, talk);

  sub = action(*app, "compare", "What differs between two calibrations of a machine, told from noise", *o);
  sub->add_option("id", o->id, "Number of the earlier calibration")->required()->type_name("ID")->group("Input");
  sub->add_option("other", o->other, "Number of the later one")->required()->type_name("ID")->group("Input");
  sub->footer("Example:\n  trunnion history compare --store shop.db 3 4");
  chosen(sub, compare, o, talk);

  sub = action(*app, "trend", "Every error over the calibrations with its 95 % band; exit status 1 beyond a limit", *o);
  add_serial(sub, *o);
  sub->add_option("--limits", o->limits, "Alarm limits (TOML: tables [value] and [change])")
      ->type_name("L.toml")
      ->group("Input");
  sub->add_option("-o,--output", o->output, "All values to write (CSV)")->type_name("T.csv")->group("Output");
  sub->footer("Example:\n  trunnion history trend --store shop.db --serial 0001 --limits limits.toml -o trend.csv");
  chosen(sub, trend, o, talk);

  sub = action(*app, "drift", "Which errors moved, since when and by how much", *o);
  add_serial(sub, *o);
  sub->add_option("-o,--output", o->output, "Findings to write (JSON)")->type_name("D.json")->group("Output");
  sub->footer("Example:\n  trunnion history drift --store shop.db --serial 0001");
  chosen(sub, drift, o, talk);

  sub = action(*app, "prior",
               "The last model, and how far the machine may have moved until a date, for identify --prior", *o);
  add_serial(sub, *o);
  sub->add_option("--date", o->date, "When the new readings are taken")->required()->type_name("DATE")->group("Input");
  sub->add_option("-o,--output", o->output, "Model to write (JSON)")
      ->required()
      ->type_name("prior.json")
      ->group("Output");
  sub->footer("Example:\n  trunnion history prior --store shop.db --serial 0001 --date 2026-09-01 -o prior.json");
  chosen(sub, prior, o, talk);

  app->footer(
      "Examples:\n"
      "  trunnion history add --store shop.db --machine machine.toml --model model.json --date 2026-03-01\n"
      "  trunnion history trend --store shop.db --serial 0001 --limits limits.toml -o trend.csv");
  return {app, [run] { return (*run)(); }};
}

}  // namespace trunnion
