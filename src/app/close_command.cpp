#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/active_compensation.h"
#include "app/changed_inputs.h"
#include "app/command.h"
#include "app/error_text.h"
#include "app/map_change.h"
#include "app/next_measurement.h"
#include "app/piece_closure.h"
#include "app/piece_outlook.h"
#include "app/progress.h"
#include "app/readings_input.h"
#include "app/terminal.h"
#include "app/text_table.h"
#include "conventions/reading_checks.h"
#include "discovery/closure.h"
#include "error.h"
#include "identification/findings.h"
#include "io/closure_file.h"
#include "io/machine_file.h"
#include "io/model_file.h"
#include "io/observed_ranges.h"
#include "io/output_file.h"
#include "io/provenance.h"

namespace trunnion {
namespace close_cli {
namespace {

struct Options {
  std::string machine, observations, verification, output, active, active_only, predict;
  PieceFiles piece;
};

std::string joined_words(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

/// What a correction makes of an effect, in words.
std::string what_becomes_of(const AcceptedEffect& e) {
  if (e.effect->origin() == Origin::measurement)
    return "of the measurement: it cleans the map, and is never compensated";
  if (!e.effect->is_compensated())
    return "of the machine, unless it is one of the measurement: not compensated until these are told apart";
  if (!e.needs.empty())
    return "of the machine: compensated where a job tells " + joined_words(e.needs) + ", left over elsewhere";
  return "of the machine: compensated";
}

std::string corner_text(const std::vector<CornerChange>& changes) {
  std::string text =
      "\nAt the corners of the working volume, um: the rotary maps change by, all that is compensated by\n";
  std::vector<std::vector<std::string>> rows = {{"X Y Z, mm", "maps rms", "largest", "all rms", "largest"}};
  for (const CornerChange& c : changes)
    rows.push_back(
        {formatted("%.0f", c.corner_mm.x()) + formatted(" %.0f", c.corner_mm.y()) + formatted(" %.0f", c.corner_mm.z()),
         formatted("%.2f", c.map_rms), formatted("%.2f", c.map_max), formatted("%.2f", c.model_rms),
         formatted("%.2f", c.model_max)});
  return text + text_table(rows);
}

/// What was found, in one sentence.
std::string verdict_sentence(const ClosureResult& r) {
  const std::string residual =
      "residual rms " + formatted("%.3f", r.after.rms_um) + " um, declared " + formatted("%.3f um", r.noise_um);
  std::string names;
  for (const AcceptedEffect& e : r.effects) names += (names.empty() ? "" : ", ") + e.effect->id();
  std::string text(verdict_text(r.verdict));
  if (r.effects.empty())
    return text +
           (r.verdict == Verdict::nothing_missing ? ": the rotary maps account for the readings, "
                                                  : ": no effect of the catalogue accounts for what is left, ") +
           residual;
  return text + ": with " + names + " the residual " + (r.after.rms_um < r.before.rms_um ? "falls" : "goes") +
         " from " + formatted("%.3f um rms", r.before.rms_um) + " to " + formatted("%.3f um, ", r.after.rms_um) +
         "declared " + formatted("%.3f um", r.noise_um);
}

std::string summary(const ClosureResult& r, const std::vector<NextMeasurement>& next, char tilt) {
  std::string text = "Verdict: " + wrapped(verdict_sentence(r), 9) + ".\n";
  text += std::to_string(r.problem.readings.size()) + " readings at " + std::to_string(r.problem.poses.size()) +
          " poses, " + std::to_string(r.columns_scanned) + " columns of candidates scanned, declared sigma " +
          formatted("%.3f um", r.noise_um) +
          (r.thinned ? "\nof a long log one reading of each run was searched, drawn at random\n\n" : "\n\n");
  std::vector<std::vector<std::string>> rows = {{"", "before", "after", ""}};
  rows.push_back({"residual rms", formatted("%.3f", r.before.rms_um), formatted("%.3f", r.after.rms_um), "um"});
  rows.push_back(
      {"reduced chi-square", formatted("%.3f", r.before.reduced_chi2), formatted("%.3f", r.after.reduced_chi2), ""});
  rows.push_back({r.has_holdout ? "poses kept back" : "poses left out in turn",
                  formatted("%.3f", r.before.holdout_rms_um), formatted("%.3f", r.after.holdout_rms_um), "um"});
  text += text_table(rows);
  for (const AcceptedEffect& e : r.effects) {
    text += "\n" + e.effect->id() + "\n";
    text += "  " +
            (e.smooth ? std::string("a smooth effect that no family of the catalogue explains")
                      : std::string(family_of(e.effect->id()).what)) +
            "; depends on " + joined_words(e.effect->depends_on()) + "\n  " + what_becomes_of(e) + "\n";
    if (!e.smooth) {
      rows.clear();
      for (std::size_t k = 0; k < e.effect->parameters().size(); ++k) {
        const Parameter& p = e.effect->parameters()[k];
        const auto i = static_cast<Eigen::Index>(k);
        rows.push_back(
            {"  " + p.name,
             with_uncertainty(to_unit(p.value, p.unit), to_unit(std::sqrt(e.effect->covariance()(i, i)), p.unit)),
             std::string(unit_text(p.unit).text)});
      }
      for (const Parameter& p : e.effect->shape())
        rows.push_back(
            {"  " + p.name, formatted("%.4g", to_unit(p.value, p.unit)), std::string(unit_text(p.unit).text)});
      text += text_table(rows);
    }
    text += "  family-wise p " + p_value_text(e.p_value) + formatted(", visible fraction %.2f", e.visible_fraction) +
            formatted(", up to %.2f um in a reading", e.largest_um) +
            formatted("\n  residual rms %.3f", e.rms_before_um) + formatted(" -> %.3f um", e.rms_after_um) +
            formatted(", poses kept back %.3f", e.holdout_before_um) + formatted(" -> %.3f um\n", e.holdout_after_um);
    if (!e.not_separable_from.empty())
      text += "  these data cannot tell it from: " + joined_words(e.not_separable_from) +
              "\n  to separate: " + e.separate_by + "\n";
    else if (e.rigid_within_poses)
      text += "  rigid within each pose: either this, or more complex rotary maps; to be sure: " + e.separate_by + "\n";
    for (const NextMeasurement& n : next)
      if (n.effect == e.effect->id()) text += n.text();
    if (e.absurd)
      text += "  its size is not credible for a sound machine: look for a mistake in the measurement first\n";
  }
  if (const RotaryErrorMap* map = r.model.rotary_map()) {
    const std::vector<ErrorFinding> errors = summarise(map->content(), tilt);
    if (std::ranges::any_of(errors, &ErrorFinding::seen))
      text += "\nThe rotary maps with all of this taken out\n" + errors_table(errors, tilt) + "\n" +
              worst_error_plot(*map, errors, tilt);
  }
  if (!r.refused.empty()) {
    text += "\nTried and refused:\n";
    for (const std::string& line : r.refused) text += "  " + line + "\n";
  }
  if (!r.untestable.empty()) {
    text += "\nNot testable with these data:\n";
    rows.clear();
    for (const Untestable& u : r.untestable) rows.push_back({u.id + ": " + u.separate_by});
    text += text_table(rows);
  }
  return text;
}

std::string piece_text(const nlohmann::json& piece) {
  std::vector<std::vector<std::string>> rows = {{"piece: measured less predicted", "before", "after", ""}};
  for (const auto& [key, title] : {std::pair("rms_um", "rms"), std::pair("roundness_um", "roundness, the largest")}) {
    rows.push_back({title});
    for (const char* stage : {"before", "after"})
      rows.back().push_back(piece[stage][key].is_number() ? formatted("%.3f", piece[stage][key].get<double>()) : "-");
    rows.back().emplace_back("um");
  }
  return "\n" + text_table(rows);
}

int run(const Options& o, const Talk& talk) {
  const Machine machine = read_machine(o.machine);
  std::vector<std::string> inputs = {o.machine};
  const auto readings = [&](const std::string& path, const std::string& role) {
    inputs.push_back(path);
    ObservationSet set = observations_input(path, machine, talk);
    if (const Check check = rounding_check(set, machine); check.outcome != Outcome::passed)
      talk.warn(path + ": " + check.found + "; " + check.advice);
    const bool active = !o.active.empty() && (o.active_only.empty() || o.active_only == role);
    return active ? without_active(std::move(set), o.active, machine, inputs) : set;
  };
  if (o.observations.empty() && o.piece.piece.empty())
    throw UsageError("--observations: wanted, or --piece and --measured");
  if (!o.active.empty())
    for (const std::string& line : changed_compensation(o.active, machine, {o.machine})) talk.warn(line);
  ObservationSet all;
  if (!o.observations.empty()) all = readings(o.observations, "observations");
  // Without readings on the machine the piece is what is searched, else it comes later than they do.
  std::size_t calibration_rows = all.rows.size();
  if (!o.verification.empty()) all = joined(all, readings(o.verification, "verification"));
  const std::size_t piece_rows = all.rows.size();
  const ObservationSet touched = all;
  std::optional<PieceClosure> piece;
  if (!o.piece.piece.empty()) {
    piece.emplace(read_cut_piece(o.piece, inputs), machine);
    const ObservationSet& points = piece->observations().set;
    all = all.rows.empty() ? points : joined_with_piece(all, points);
    if (o.observations.empty()) calibration_rows = all.rows.size();
    if (piece->observations().unsteady > 0)
      talk.say(std::to_string(piece->observations().unsteady) +
               " points of the piece left out: an axis reversed while they were cut");
  }
  ClosureResult result;
  {
    Progress progress(talk, "search " + std::to_string(all.rows.size()) + " readings");
    ClosureOptions options;
    options.progress = [&](const std::string& step) { progress.now(step); };
    result = close_loop(all, calibration_rows, machine, options);
  }
  const std::vector<NextMeasurement> next =
      next_measurements(result, result.thinned && !piece ? *result.thinned : touched, machine);
  nlohmann::json closure = closure_json(result);
  for (nlohmann::json& entry : closure["effects"])
    for (const NextMeasurement& n : next)
      if (n.effect == entry["id"]) entry["separate_rows"] = n.json();
  if (piece) closure["piece"] = piece->json(result, piece_rows);
  closure["machine"] = {{"name", machine.name}, {"serial", machine.serial}};
  std::vector<CornerChange> changes;
  if (!result.effects.empty()) try {
      changes = change_at_corners(result.bare_model, result.model, working_volume(machine, result.model));
      closure["map_change"] = map_change_json(changes, machine.tilt_letter());
    } catch (const RangeError& e) {
      talk.warn(std::string(e.what()) + "; the change of the map at the corners is left out");
    }
  std::string outlook;
  if (!o.predict.empty()) try {
      std::vector<std::string> notes;
      const Progress progress(talk, "prediction of " + o.predict);
      closure["predicted_piece"] = piece_outlook(machine, result, o.predict, o.piece.job, inputs, notes);
      outlook = piece_outlook_text(closure["predicted_piece"]);
      for (const std::string& note : notes) talk.warn(note);
    } catch (const RangeError& e) {
      talk.warn(std::string(e.what()) + "; the prediction is left out");
    }
  const nlohmann::json provenance = provenance_json(inputs);
  closure.update(provenance);
  nlohmann::json fit = {{"method", "closure"},
                        {"verdict", closure["verdict"]},
                        {"before", closure["before"]},
                        {"after", closure["after"]},
                        {"observed", observed_json(all)}};
  fit.update(provenance);
  result.model.fit = std::make_shared<nlohmann::json>(std::move(fit));
  for (const std::size_t i : result.outliers)
    talk.warn(all.place(result.problem.readings[i].row) + ": left out as an outlier" +
              formatted(" (residual %.2f um); touch that spot again", 1e3 * result.residual_after[i]));
  OutputFolder folder(o.output, inputs);
  folder.add("closure.json", closure.dump(1) + "\n");
  folder.add("model.json", model_text(result.model));
  folder.add("residuals.csv", residual_csv(result, machine.tilt_letter()));
  if (piece) folder.add("piece.csv", piece->csv(result, piece_rows));
  for (const NextMeasurement& n : next) folder.add(n.file, n.rows);
  folder.commit();
  talk.show(summary(result, next, machine.tilt_letter()) + (changes.empty() ? "" : corner_text(changes)) +
            (piece ? piece_text(closure["piece"]) : "") + outlook);
  if (talk.json) std::printf("%s\n", closure.dump(1).c_str());
  talk.say("wrote " + o.output + "/closure.json, model.json, residuals.csv");
  return 0;
}

}  // namespace
}  // namespace close_cli

Command close_command(CLI::App& program, const Talk& talk) {
  using namespace close_cli;
  auto o = std::make_shared<Options>();
  CLI::App* app = program.add_subcommand(
      "close", "Close the loop: residual, its cause, the extended model, error before and after");
  app->add_option("--machine", o->machine, "Machine file (TOML)")->required()->type_name("M.toml")->group("Input");
  app->add_option("--observations", o->observations, "The calibration (CSV); may be missing where a piece is given")
      ->type_name("O.csv")
      ->group("Input");
  app->add_option("--verification", o->verification,
                  "A later measurement at other angles (CSV); part of it is kept back")
      ->type_name("V.csv")
      ->group("Input");
  CLI::Option* active = app->add_option("--active", o->active,
                                        "The compensation that was switched on while measuring: a tables folder, or a "
                                        "model")
                            ->type_name("DIR|model.json")
                            ->group("Input");
  app->add_option("--active-only", o->active_only, "Which of the two files was measured with it; default: both")
      ->check(CLI::IsMember({"observations", "verification"}))
      ->needs(active)
      ->group("Input");
  CLI::Option* piece = app->add_option("--piece", o->piece.piece, "A test piece that was cut on the machine (TOML)")
                           ->type_name("P.toml")
                           ->group("Piece");
  CLI::Option* measured = app->add_option("--measured", o->piece.measured, "What was measured of it (CSV)")
                              ->type_name("T.csv")
                              ->needs(piece)
                              ->group("Piece");
  piece->needs(measured);
  app->add_option("--program", o->piece.program, "The program that cut it; default: the planned path")
      ->type_name("N.nc")
      ->needs(piece)
      ->group("Piece");
  app->add_option("--job", o->piece.job, "Work offsets and covariates of the piece (TOML)")
      ->type_name("J.toml")
      ->group("Piece");
  app->add_option("--predict", o->predict,
                  "A test piece that is to be cut (TOML): its roundness by the maps alone and with what was found")
      ->type_name("P.toml")
      ->group("Piece");
  app->add_option("-o,--output", o->output,
                  "Folder for closure.json, model.json, residuals.csv, piece.csv and next.csv")
      ->required()
      ->type_name("DIR")
      ->group("Output");
  app->footer(
      "Examples:\n  trunnion close --machine machine.toml --observations calibration.csv --verification later.csv -o "
      "closed\n  trunnion close "
      "--machine machine.toml --observations calibration.csv --piece piece.toml --measured traces.csv -o closed\n  "
      "trunnion close --machine machine.toml "
      "--observations calibration.csv --predict piece.toml -o closed");
  return {app, [o, &talk] { return run(*o, talk); }};
}

}  // namespace trunnion
