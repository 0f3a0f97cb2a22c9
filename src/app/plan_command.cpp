#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/changed_inputs.h"
#include "app/command.h"
#include "app/progress.h"
#include "app/readings_input.h"
#include "app/text_table.h"
#include "error.h"
#include "io/csv.h"
#include "io/machine_file.h"
#include "io/model_file.h"
#include "io/observation_file.h"
#include "io/output_file.h"
#include "io/probe_program.h"
#include "io/text_file.h"
#include "model/effects/rotary_error_map.h"
#include "planning/power.h"

namespace trunnion {
namespace plan_cli {
namespace {

constexpr std::size_t kFewestTouches = 6;  // six errors of a pose

static_assert(ProbeMoves().standoff_mm <= kLargestStandoff_mm);

struct Options {
  std::string machine, model, observations, spots, nc, output;
  std::vector<std::string> separate;
  std::size_t visits = 6, touches = 12;
  double touch_s = 7, pose_s = 6;
  double minutes = std::numeric_limits<double>::infinity();
  ProbeMoves moves;
};

std::string size_text(const SmallestSeen& s) {
  return std::isfinite(s.size) ? formatted("%.3g", to_unit(s.size, s.unit)) : "cannot be seen";
}

std::string summary(const ObservationSet& set, std::size_t visits, const PowerPlan& plan) {
  std::string text = std::to_string(set.rows.size()) + " touches at " + std::to_string(visits) + " visits, about " +
                     formatted("%.0f min\n", (set.rows.back().time_s - set.rows.front().time_s) / 60);
  if (plan.before.empty()) return text;
  text += "\nSmallest size found nine times in ten, beside smooth rotary maps:\n";
  std::vector<std::vector<std::string>> rows = {{"", "", "so far", "with the plan", ""}};
  for (std::size_t k = 0; k < plan.before.size(); ++k)
    rows.push_back({plan.before[k].effect, plan.before[k].parameter, size_text(plan.before[k]),
                    size_text(plan.after[k]), std::string(unit_text(plan.before[k].unit).text)});
  return text + text_table(rows);
}

nlohmann::json power_json(const PowerPlan& plan) {
  nlohmann::json power = nlohmann::json::array();
  for (std::size_t k = 0; k < plan.before.size(); ++k) {
    const auto size = [](const SmallestSeen& s) {
      return std::isfinite(s.size) ? nlohmann::json(to_unit(s.size, s.unit)) : nlohmann::json();
    };
    power.push_back({{"id", plan.before[k].effect},
                     {"parameter", plan.before[k].parameter},
                     {"unit", unit_text(plan.before[k].unit).text},
                     {"smallest_before", size(plan.before[k])},
                     {"smallest_after", size(plan.after[k])}});
  }
  return power;
}

/// Spots as they stand in W: point, artifact, place and outward normal (CSV).
std::vector<Spot> read_spots(const std::string& path) {
  const std::string text = read_text(path);
  CsvReader csv(text, path);
  const auto column = [&](const char* name) {
    const auto found = csv.find(name);
    if (!found) throw InputError(path, csv.line(), std::string("column ") + name + " is missing");
    return *found;
  };
  const std::size_t point = column("point"), artifact = column("artifact");
  std::array<std::size_t, 6> numbers{};
  std::size_t k = 0;
  for (const char* name : {"x_mm", "y_mm", "z_mm", "nx", "ny", "nz"}) numbers[k++] = column(name);
  std::vector<Spot> spots;
  std::vector<std::string_view> fields;
  while (csv.next(fields)) {
    Spot spot{std::string(fields[point]), std::string(fields[artifact])};
    for (std::size_t i = 0; i < 6; ++i)
      (i < 3 ? spot.place_w_mm : spot.outward_w)[static_cast<Eigen::Index>(i % 3)] =
          csv.number(fields[numbers[i]], numbers[i]);
    if (std::abs(spot.outward_w.norm() - 1) > 1e-3)
      throw InputError(path, csv.line(), "nx, ny, nz: a unit vector out of the face is wanted");
    spot.outward_w.normalize();
    if (spot.point.empty()) throw InputError(path, csv.line(), "point: a label is wanted");
    for (const Spot& other : spots)
      if (other.point == spot.point) throw InputError(path, csv.line(), "point " + spot.point + " stands there twice");
    spots.push_back(std::move(spot));
  }
  if (spots.empty()) throw InputError(path, "no spot in it");
  return spots;
}

double duration_min(const ObservationSet& set) { return set.rows.back().time_s / 60; }

/// A first calibration within the time: as many touches at a position as that allows. Throws UsageError where even the
/// fewest take longer.
std::vector<Visit> first_plan_in_time(const Machine& machine, const std::vector<Spot>& spots, PlanOptions pace,
                                      double minutes) {
  for (;; --pace.touches) {
    std::vector<Visit> visits = first_plan(machine, spots, pace);
    if (visits.empty()) return visits;
    const double takes = duration_min(planned_observations(machine, spots, visits, pace, "first plan"));
    if (takes <= minutes) return visits;
    if (pace.touches <= kFewestTouches)
      throw UsageError("--minutes " + formatted("%g", minutes) + ": a first calibration with " +
                       std::to_string(kFewestTouches) + " touches at a position takes " + formatted("%.0f", takes));
  }
}

int run(const Options& o, const Talk& talk) {
  const Machine machine = read_machine(o.machine);
  const KinematicChain chain(machine);
  std::vector<std::string> inputs = {o.machine};
  PlanOptions pace{.pose_s = o.pose_s, .touch_s = o.touch_s, .touches = o.touches};
  if (!o.model.empty()) {
    const Model model = read_model(o.model, machine);
    check_same_machine(model, machine, o.model);
    for (const std::string& line : changed_inputs(model, o.model, {o.machine})) talk.warn(line);
    inputs.push_back(o.model);
    if (const RotaryErrorMap* map = model.rotary_map())  // what was probed is what can be asked again
      pace.tilt_low = map->surface().a_range().low, pace.tilt_high = map->surface().a_range().high;
  }
  std::vector<Spot> spots = column_spots();
  if (!o.spots.empty()) {
    spots = read_spots(o.spots);
    inputs.push_back(o.spots);
  }
  ObservationSet so_far;
  if (!o.observations.empty()) {
    so_far = observations_input(o.observations, machine, talk);
    spots = spots_of(so_far, chain);
    if (spots.empty()) throw InputError(o.observations, "no contact in it; a plan is one of touches");
    inputs.push_back(o.observations);
  }
  std::vector<Visit> visits;
  if (o.observations.empty()) {
    visits = first_plan_in_time(machine, spots, pace, o.minutes);
    if (visits.empty())
      throw RangeError(o.spots.empty()
                           ? "plan: the columns of 100 mm that it takes for granted are beyond the strokes of this "
                             "machine; --spots says what stands on the table"
                           : o.spots + ": no spot can be reached within the strokes of this machine");
    so_far = planned_observations(machine, spots, visits, pace, "first plan");
  } else if (o.separate.empty()) {
    throw UsageError("--separate: wanted with --observations: which effect is to be seen");
  }
  PowerPlan power;
  ObservationSet set = o.observations.empty() ? so_far : ObservationSet{};
  if (!o.separate.empty()) {
    if (o.separate.size() > 2) throw UsageError("--separate: one effect, or two with a comma between");
    Progress progress(talk, "plan", static_cast<double>(o.visits), "visits");
    const double spent_min = o.observations.empty() ? duration_min(so_far) : 0;
    power = plan_for_power(so_far, machine, spots, {o.separate},
                           {o.visits, 60 * (o.minutes - spent_min), pace,
                            [&](std::size_t done) { progress.at(static_cast<double>(done)); }});
    if (power.visits.empty() && !o.observations.empty())
      throw UsageError("--minutes " + formatted("%g", o.minutes) + ": no further visit is that short");
    visits.insert(visits.end(), power.visits.begin(), power.visits.end());
    if (o.observations.empty()) {
      set = planned_observations(machine, spots, visits, pace, "plan");
    } else {
      for (const Observation& r : so_far.rows) pace.start_s = std::max(pace.start_s, r.time_s);
      set = planned_observations(machine, spots, power.visits, pace, "plan");
    }
  }
  const std::filesystem::path output(o.output);
  if (o.nc.empty()) {
    write_whole(o.output, observations_text(set, machine.tilt_letter()), inputs);
  } else {
    if (output.extension() == ".ngc")
      throw UsageError("--output: a .csv is wanted; the program stands beside it as .ngc");
    std::filesystem::path program = output, log = output.filename();
    program.replace_extension(".ngc");
    log.replace_extension(".log");
    const std::string text = linuxcnc_probe_program(set, machine, o.moves, log.string());
    write_whole(program.string(), text, inputs);
    write_whole(o.output, observations_text(set, machine.tilt_letter()), inputs);
    talk.say("wrote " + program.string() + "; its log " + log.string() + " is for `trunnion import probe-log`");
  }
  talk.show(summary(set, o.observations.empty() ? visits.size() : power.visits.size(), power));
  if (talk.json)
    std::printf("%s\n", nlohmann::json({{"touches", set.rows.size()}, {"power", power_json(power)}}).dump(1).c_str());
  talk.say("wrote " + o.output);
  return 0;
}

struct ImportOptions {
  std::string machine, log, output;
};

int import_log(const ImportOptions& o, const Talk& talk) {
  const Machine machine = read_machine(o.machine);
  const ObservationSet set = probe_log_input(o.log, machine, talk);
  write_whole(o.output, observations_text(set, machine.tilt_letter()), {o.machine, o.log});
  if (talk.json)
    std::printf("%s\n",
                nlohmann::json({{"touches", set.rows.size()}, {"spots", set.points.size()}, {"output", o.output}})
                    .dump(1)
                    .c_str());
  talk.say("wrote " + o.output + ": " + std::to_string(set.rows.size()) + " touches of " +
           std::to_string(set.points.size()) + " spots");
  return 0;
}

}  // namespace
}  // namespace plan_cli

Command plan_command(CLI::App& program, const Talk& talk) {
  using namespace plan_cli;
  auto o = std::make_shared<Options>();
  CLI::App* app = program.add_subcommand("plan", "Where to probe next, what it will tell, and the probing program");
  app->add_option("--machine", o->machine, "Machine file (TOML)")->required()->type_name("M.toml")->group("Input");
  app->add_option("--model", o->model, "A model of it: the tilts that it was probed at bound the plan")
      ->type_name("model.json")
      ->group("Input");
  app->add_option("--observations", o->observations, "What was measured so far (CSV); without, a first calibration")
      ->type_name("O.csv")
      ->group("Input");
  app->add_option("--spots", o->spots,
                  "Faces on the table, in W: point,artifact,x_mm,y_mm,z_mm,nx,ny,nz (CSV); default: three columns")
      ->type_name("S.csv")
      ->excludes("--observations")
      ->group("Input");
  app->add_option("--separate", o->separate, "Effects to be seen, and told apart: ID or ID,ID")
      ->delimiter(',')
      ->type_name("ID,ID")
      ->group("Plan");
  app->add_option("--visits", o->visits, "Further visits to indexed positions")
      ->check(CLI::Range(1, 60))
      ->capture_default_str()
      ->group("Plan");
  app->add_option("--touches", o->touches, "Touches at a position, at most")
      ->check(CLI::Range(6, 200))
      ->capture_default_str()
      ->group("Plan");
  app->add_option("--touch-s", o->touch_s, "What one touch takes, s")
      ->check(CLI::Range(0.1, 600.0))
      ->capture_default_str()
      ->group("Plan");
  app->add_option("--pose-s", o->pose_s, "What a change of position takes, s")
      ->check(CLI::Range(0.1, 600.0))
      ->capture_default_str()
      ->group("Plan");
  app->add_option("--minutes", o->minutes, "What the plan may take in all, min")
      ->check(CLI::Range(1.0, 1e5))
      ->type_name("MIN")
      ->group("Plan");
  app->add_option("--nc", o->nc, "Also write the probing program beside it")
      ->check(CLI::IsMember({"linuxcnc"}))
      ->type_name("linuxcnc")
      ->group("Output");
  app->add_option("--feed", o->moves.feed_mm_per_min, "Of a probing move, mm/min")
      ->check(CLI::Range(1.0, 2000.0))
      ->capture_default_str()
      ->needs("--nc")
      ->group("Output");
  app->add_option("--standoff", o->moves.standoff_mm, "Of the ball from a face before it is probed, mm")
      ->check(CLI::Range(0.1, kLargestStandoff_mm))
      ->capture_default_str()
      ->needs("--nc")
      ->group("Output");
  app->add_option("--clearance", o->moves.clearance_mm, "Above whatever stands on the table, between spots, mm")
      ->check(CLI::Range(1.0, 1000.0))
      ->capture_default_str()
      ->needs("--nc")
      ->group("Output");
  app->add_option("-o,--output", o->output, "The plan: an observations file with nominal places (CSV)")
      ->required()
      ->type_name("plan.csv")
      ->group("Output");
  app->footer(
      "Examples:\n  trunnion plan --machine machine.toml --nc linuxcnc -o plan.csv\n"
      "  trunnion plan --machine machine.toml --observations calibration.csv --separate backlash:C,thermal_drift -o "
      "next.csv");
  return {app, [o, &talk] { return run(*o, talk); }};
}

Command import_command(CLI::App& program, const Talk& talk) {
  using namespace plan_cli;
  auto o = std::make_shared<ImportOptions>();
  CLI::App* app = program.add_subcommand("import", "Readings from what a control wrote");
  CLI::App* log = app->add_subcommand("probe-log", "The log of a probing program of `plan --nc linuxcnc`");
  app->require_subcommand(1);
  app->footer("Example:\n  trunnion import probe-log plan.log --machine machine.toml -o observations.csv");
  log->add_option("LOG", o->log, "The log")->required()->type_name("plan.log");
  log->add_option("--machine", o->machine, "Machine file (TOML)")->required()->type_name("M.toml")->group("Input");
  log->add_option("-o,--output", o->output, "Observations to write (CSV)")
      ->required()
      ->type_name("O.csv")
      ->group("Output");
  log->footer("Example:\n  trunnion import probe-log plan.log --machine machine.toml -o observations.csv");
  return {app, [o, &talk] { return import_log(*o, talk); }};
}

}  // namespace trunnion
