#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/active_compensation.h"
#include "app/changed_inputs.h"
#include "app/command.h"
#include "app/error_text.h"
#include "app/prior_map.h"
#include "app/progress.h"
#include "app/readings_input.h"
#include "app/terminal.h"
#include "app/text_table.h"
#include "conventions/reading_checks.h"
#include "error.h"
#include "identification/identify.h"
#include "io/identification_report.h"
#include "io/machine_file.h"
#include "io/model_file.h"
#include "io/observed_ranges.h"
#include "io/output_file.h"

namespace trunnion {
namespace identify_cli {
namespace {

struct Options {
  std::string machine, observations, output, method = "joint", interpolation, prior, active;
  double drift_um = -1, drift_urad = -1;  ///< negative: as the prior says
  bool fill = false, no_robust = false;
};

/// What was found, in one sentence.
std::string verdict(const IdentificationResult& r, char tilt) {
  const auto unseen = std::ranges::count(r.errors, false, &ErrorFinding::seen);
  if (unseen == std::ssize(r.errors))
    return "these readings determine none of the errors: see what is not seen, and touch more at each position";
  const auto told = std::ranges::count(r.errors, true, &ErrorFinding::told_from_zero);
  const ErrorFinding& worst = worst_error(r.errors);
  return std::to_string(told) + " of " + std::to_string(r.errors.size()) + " errors are told from zero" +
         (unseen > 0 ? ", " + std::to_string(unseen) + " are not seen" : std::string()) + ", the largest is " +
         worst.symbol + ", " +
         with_uncertainty(to_unit(worst.largest, worst.unit), to_unit(worst.largest_std, worst.unit)) + " " +
         std::string(unit_text(worst.unit).text) + " at " +
         position_text(worst.largest_at, tilt, worst.symbol.back() == 'C') +
         (r.sigma_from_readings
              ? formatted(", and the readings, which declare no sigma, scatter by %.3g um", r.sigma_found_um)
          : r.chi_square_p < 1e-3
              ? ", and the readings scatter more than declared: something is missing, run trunnion close"
          : r.freedom < 1 ? ", and no reading checks another"
                          : ", and the readings scatter as declared");
}

enum class Verbose { no, yes };

std::string summary(const IdentificationResult& r, const Machine& machine, Verbose verbose) {
  const char tilt = machine.tilt_letter();
  std::string text = "Verdict: " + wrapped(verdict(r, tilt), 9) + ".\n\nReadings " + std::to_string(r.readings) +
                     ", unknowns " + std::to_string(r.unknowns) + ", rank " + std::to_string(r.rank) +
                     formatted(", degrees of freedom %.0f", r.freedom) + formatted(", condition %.1f", r.condition) +
                     "\n";
  text +=
      formatted("Sigma found %.3f um", r.sigma_found_um) +
      (r.sigma_from_readings ? std::string(", none declared") : formatted(", declared %.3f um", r.sigma_declared_um)) +
      formatted("; reduced chi-square %.3f", r.reduced_chi_square) + formatted(" (p %.2g)", r.chi_square_p) +
      (r.sigma_from_readings   ? ": by construction"
       : r.chi_square_p < 1e-3 ? ": more scatter than the probe has, see trunnion close"
       : r.freedom < 1         ? ": nothing is left to judge it by"
                               : ": as declared") +
      "\n";
  if (r.uncertainty_scale > 1)
    text += formatted("Standard uncertainties are enlarged by %.2f accordingly\n", r.uncertainty_scale);
  if (r.belief)
    text += formatted("Against the prior: chi-square %.1f", r.belief->chi_square) +
            formatted(" at %.0f degrees of freedom", r.belief->freedom) + formatted(" (p %.2g)\n", r.belief->p_value);
  text += formatted("Least redundancy of a reading %.3f", r.worst_redundancy) +
          ", readings that nothing checks: " + std::to_string(r.unchecked.size()) + "\n\n";

  text += errors_table(r.errors, tilt);
  if (const RotaryErrorMap* map = r.model.rotary_map();
      map != nullptr && std::ranges::any_of(r.errors, &ErrorFinding::seen)) {
    text += "\n" + worst_error_plot(*map, r.errors, tilt);
    if (verbose == Verbose::yes) text += "\nAt every node\n" + nodes_table(*map, tilt);
  }
  std::vector<std::vector<std::string>> rows;
  if (!r.location.symbols.empty()) {
    text += "\nLocation errors in these maps";
    text +=
        r.location.p_value > 0.01
            ? formatted(": nothing else is told from noise (p %.2g)\n", r.location.p_value)
            : formatted("; they leave chi-square %.0f", r.location.chi_square) +
                  formatted(" at %.0f degrees of freedom, so the errors move with the angles\n", r.location.freedom);
    rows.clear();
    for (std::size_t k = 0; k < r.location.symbols.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      rows.push_back({r.location.symbols[k],
                      with_uncertainty(to_unit(r.location.values[i], r.location.units[k]),
                                       to_unit(std::sqrt(r.location.covariance(i, i)), r.location.units[k])),
                      std::string(unit_text(r.location.units[k]).text)});
    }
    text += text_table(rows);
  }
  if (!r.interpolation.empty()) {
    text +=
        "\nBetween the nodes: " + r.chosen_interpolation + ". Left-out angles are missed by, at a lever of 100 mm:\n";
    rows.clear();
    for (const InterpolationEvidence& e : r.interpolation)
      rows.push_back({e.method, formatted("%.2f um", e.score_um), formatted("(D %.2f um,", e.rms_um),
                      formatted("theta %.2f urad)", e.rms_urad)});
    text += text_table(rows);
  } else {
    text += "\nBetween the nodes: " + r.chosen_interpolation + "\n";
  }
  return text;
}

void warn(const IdentificationResult& r, const Talk& talk, char tilt) {
  const ObservationSet& set = *r.problem.observations;
  for (const Outlier& o : r.outliers)
    talk.warn(set.place(r.problem.readings[o.reading].row) + ": left out as an outlier: residual " +
              formatted("%.2f um", 1e3 * o.residual) +
              formatted(", %.1f of its standard deviations; touch that spot again", o.normalised));
  if (!r.crowd.empty())
    talk.warn(std::to_string(r.crowded.size()) + " readings are far off and stand together (" + r.crowd +
              "): an effect that the map lacks, not chips; none was left out, run trunnion close");
  if (!r.unchecked.empty())
    talk.warn(std::to_string(r.unchecked.size()) + " readings cannot be checked by any other (first: " +
              set.place(r.problem.readings[r.unchecked.front()].row) + "); a second spot on those faces would do it");
  constexpr std::size_t kShown = 3;  // poses; all of them with --verbose
  std::size_t poses = 0;
  for (std::size_t k = 0; k < r.unseen.size(); ++k) {
    const bool first = k == 0 || r.unseen[k].pose != r.unseen[k - 1].pose;
    poses += first ? 1 : 0;
    if (poses > kShown && !talk.verbose) continue;
    std::string components;
    for (const std::size_t c : r.unseen[k].components)
      components +=
          std::string(components.empty() ? "" : ", ") + std::vector<const char*>{"Dx", "Dy", "Dz", "Da", "Db", "Dc"}[c];
    talk.warn("pose " + position_text(r.problem.poses[r.unseen[k].pose].at, tilt, true) +
              ": no reading sees a freedom in " + components +
              "; its errors are left unknown (--fill takes them from the smooth fit)");
  }
  if (poses > kShown && !talk.verbose)
    talk.warn("freedoms of " + std::to_string(poses - kShown) + " more poses are not seen (--verbose names them)");
  for (const std::string& name : r.undetermined) talk.warn(name + ": not determined by these readings");
  if (r.belief && r.belief->p_value < 1e-3)
    talk.warn("the readings contradict the prior (p " + p_value_text(r.belief->p_value) + ")" +
              ": the machine has moved further than the drift allows, or was set up otherwise; measure it in full and "
              "identify without --prior");
  if (!r.interpolated_nodes.empty())
    talk.warn(std::to_string(r.interpolated_nodes.size()) +
              " grid positions were not probed (first: " + position_text(r.interpolated_nodes.front(), tilt, true) +
              "); the smooth fit stands in, with its uncertainty");
}

EarlierMap earlier_map(const Options& o, const Machine& machine, const Talk& talk) {
  const auto told = [](double option) { return option >= 0 ? std::optional(option) : std::nullopt; };
  const Model earlier = read_model(o.prior, machine);
  for (const std::string& line : changed_inputs(earlier, o.prior, {o.machine})) talk.warn(line);
  PriorMap prior = prior_map(earlier, o.prior, told(o.drift_um), told(o.drift_urad));
  for (const std::string& note : prior.notes) talk.warn(note);
  return std::move(prior.earlier);
}

int run(const Options& o, const Talk& talk) {
  const Machine machine = read_machine(o.machine);
  ObservationSet observations = observations_input(o.observations, machine, talk);
  if (const Check check = rounding_check(observations, machine); check.outcome != Outcome::passed)
    talk.warn(o.observations + ": " + check.found + "; " + check.advice);
  IdentificationOptions options{.robust = !o.no_robust, .fill = o.fill, .interpolation = o.interpolation};
  options.method = o.method == "two-step" ? IdentificationMethod::two_step : IdentificationMethod::joint;
  std::vector<std::string> inputs = {o.machine, o.observations};
  if (!o.active.empty()) {
    for (const std::string& line : changed_compensation(o.active, machine, {o.machine})) talk.warn(line);
    observations = without_active(std::move(observations), o.active, machine, inputs);
  }
  if (!o.prior.empty()) {
    options.earlier = earlier_map(o, machine, talk);
    inputs.push_back(o.prior);
  }
  IdentificationResult result;
  {
    const auto readings = static_cast<double>(observations.rows.size());
    Progress progress(talk, "identify", readings, "readings");
    options.progress = [&](double share) { progress.at(share * readings); };
    result = identify(observations, machine, options);
    progress.at(readings);
  }
  nlohmann::json fit = identification_json(result, machine, inputs);
  if (options.earlier) {
    fit["prior"]["drift"] = {{"um", options.earlier->drift.length.in_micrometres()},
                             {"urad", options.earlier->drift.angle.in_microradians()}};
  }
  if (!o.active.empty()) fit["active"] = o.active;
  fit["observed"] = observed_json(observations);
  result.model.fit = std::make_shared<nlohmann::json>(fit);
  warn(result, talk, machine.tilt_letter());
  write_whole(o.output, model_text(result.model), inputs);
  talk.show(summary(result, machine, talk.verbose ? Verbose::yes : Verbose::no));
  if (talk.json) std::printf("%s\n", fit.dump(1).c_str());
  talk.say("wrote " + o.output);
  return 0;
}

}  // namespace
}  // namespace identify_cli

Command identify_command(CLI::App& program, const Talk& talk) {
  using namespace identify_cli;
  auto o = std::make_shared<Options>();
  CLI::App* app = program.add_subcommand("identify", "Error maps with standard uncertainties from measurements");
  app->add_option("--machine", o->machine, "Machine file (TOML)")->required()->type_name("M.toml")->group("Input");
  app->add_option("--observations", o->observations, "Measurements (CSV)")
      ->required()
      ->type_name("O.csv")
      ->group("Input");
  app->add_option("--active", o->active,
                  "The compensation that was switched on while measuring: a tables folder, or a model")
      ->type_name("DIR|model.json")
      ->group("Input");
  app->add_option("-o,--output", o->output, "Model to write (JSON)")
      ->required()
      ->type_name("model.json")
      ->group("Output");
  app->add_option("--method", o->method,
                  "joint: one least squares over all poses; two-step: pose by pose, as the paper")
      ->check(CLI::IsMember({"joint", "two-step"}))
      ->capture_default_str()
      ->group("Fit");
  app->add_option("--interpolation", o->interpolation, "Between the nodes; default: what predicts left-out angles best")
      ->check(CLI::IsMember({"gaussian-process", "trig-cubic", "bilinear", "natural-neighbour"}))
      ->group("Fit");
  CLI::Option* prior =
      app->add_option("--prior", o->prior, "An earlier model of this machine, believed as far as the drift allows")
          ->type_name("model.json")
          ->group("Fit");
  for (const auto& [name, value] : {std::pair("--drift-um", &o->drift_um), std::pair("--drift-urad", &o->drift_urad)})
    app->add_option(name, *value, "How far an error may have moved since the prior, 1 sigma; else as the prior says")
        ->check(CLI::Range(0.0, 1e6))
        ->needs(prior)
        ->group("Fit");
  app->add_flag("--fill", o->fill, "Let the smooth fit stand in for freedoms that no reading determines")->group("Fit");
  app->add_flag("--no-robust", o->no_robust, "Do not look for outliers")->group("Fit");
  app->footer("Example:\n  trunnion identify --machine machine.toml --observations replica.csv -o model.json");
  return {app, [o, &talk] { return run(*o, talk); }};
}

}  // namespace trunnion
