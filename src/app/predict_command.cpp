#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/command.h"
#include "app/text_table.h"
#include "compensation/controller.h"
#include "compensation/verification.h"
#include "error.h"
#include "io/job_file.h"
#include "io/machine_file.h"
#include "io/model_file.h"
#include "io/output_file.h"
#include "io/piece_file.h"
#include "io/prediction_file.h"
#include "io/text_file.h"
#include "model/effects/rotary_error_map.h"
#include "postproc/correction.h"
#include "postproc/model_field.h"
#include "postproc/playback.h"
#include "testpiece/part_view.h"
#include "testpiece/piece_program.h"
#include "testpiece/piece_solid.h"
#include "testpiece/plots.h"

namespace trunnion {
namespace {

struct Options {
  std::string machine, model, piece, program, job, measured, tables, output;
  bool corrected = false, first_order = false, sensitivity = false;
  double filter_upr = 0, magnify = 0;
  int draws = 2000;
  std::uint64_t seed = 1;
  int steps = 7200;
};

/// One way in which the piece is cut.
struct Cut {
  std::string name;  ///< as in prediction.json
  std::vector<ToolPosition> path;
  std::vector<ToolInWorkpiece> tools;
  PredictedPiece found;
};

std::string degrees(Angle a) { return formatted("%.6g", a.in_degrees()); }

class Prediction {
 public:
  Prediction(const Options& options, const Talk& talk)
      : o_(options),
        talk_(talk),
        machine_(read_machine(o_.machine)),
        model_(read_model(o_.model, machine_)),
        piece_(read_piece(o_.piece)),
        chain_(machine_),
        surface_(evaluated_surface(piece_)),
        output_(o_.output, inputs()) {
    if (!o_.job.empty()) read_covariates();
    planned_ = flank_milling_path(piece_, chain_, {.steps_per_turn = o_.steps});
    program_ = o_.program.empty() ? piece_program(piece_, planned_, machine_.tilt_letter()) : read_text(o_.program);
    path_ = o_.program.empty() ? planned_ : path_of(program_, o_.program);
    if (o_.filter_upr > 0) evaluation_.filter_upr = o_.filter_upr;
  }

  int run() {
    if (o_.first_order && (!o_.program.empty() || o_.corrected))
      throw UsageError("--first-order: it takes the planned path; programs are cut by the envelope");
    check_reach();
    tell_unknown();
    cut("uncompensated", path_);
    if (!o_.tables.empty()) cut("tables", under_tables());
    if (o_.corrected) {
      corrected_program_ = corrected();
      cut("corrected", path_of(corrected_program_, "the corrected program"));
      cut("ideal", ideal());
    }
    spread();
    write();
    show();
    return 0;
  }

 private:
  std::vector<std::string> inputs() const {
    std::vector<std::string> list = {o_.machine, o_.model, o_.piece};
    for (const std::string* more : {&o_.measured, &o_.program, &o_.job})
      if (!more->empty()) list.push_back(*more);
    return list;
  }

  /// Every commanded tilt lies within what was probed and within the stroke.
  void check_reach() const {
    const RotaryErrorMap* map = model_.rotary_map();
    const std::string tilt(1, machine_.tilt_letter());
    for (const ToolPosition& p : path_) {
      const std::string where = o_.piece + ": at phi " + degrees(Angle::radians(p.phi_rad)) + " deg " + tilt +
                                " stands at " + degrees(p.at.a);
      if (map != nullptr && !map->surface().covers(p.at.a)) {
        const Range<Angle> range = map->surface().a_range();
        throw RangeError(where + " deg, probed is " + degrees(range.low) + " to " + degrees(range.high) + " deg");
      }
      if (const auto& stroke = machine_.tilt().range_angle; stroke && (p.at.a < stroke->low || p.at.a > stroke->high))
        throw RangeError(where + " deg, its stroke is " + degrees(stroke->low) + " to " + degrees(stroke->high) +
                         " deg");
    }
  }

  void tell_unknown() {
    const std::string tilt_dir = std::string(1, machine_.tilt_letter()) + "_dir";
    for (const std::string& column : needed_covariates(model_)) {
      if (column == tilt_dir || column == "C_dir" || job_.covariates.contains(column) ||
          (column == "time_s" && piece_.feed_mm_per_min))
        continue;
      notes_.push_back("effects of " + column + " stand at their zero: the piece does not tell it" +
                       (column == "time_s" ? " (path.feed_mm_per_min would)" : ""));
    }
    for (const std::string& note : notes_) talk_.warn(note);
  }

  void cut(const std::string& name, std::vector<ToolPosition> path) {
    Cut made{.name = name, .path = std::move(path)};
    made.tools = actual_tools(made.path, chain_, model_, piece_.tool.length, known_);
    made.found.deviation_mm = o_.first_order ? first_order_deviation_mm(piece_, surface_, made.path, made.tools)
                                             : envelope_deviation_mm(piece_, surface_, made.tools);
    made.found.evaluation =
        evaluate_cone(traces_of(piece_, surface_, made.found.deviation_mm), piece_.cone.half_angle, evaluation_);
    cuts_.push_back(std::move(made));
  }

  /// The path with other commands: rotary axes at `at`, the tip at `tip_r_mm`.
  template <class Command>
  std::vector<ToolPosition> recommanded(Command command) const {
    std::vector<ToolPosition> path = path_;
    for (ToolPosition& p : path) command(p);
    set_senses(path, chain_, piece_.tool.length);
    return path;
  }

  void apply(ToolPosition& p, const AxisCorrection& correction) const {
    const IndexedPosition to{p.at.a + Angle::radians(correction.tilt_rad),
                             p.at.c + Angle::radians(correction.turn_rad)};
    const Eigen::Vector3d gauge(0, 0, -piece_.tool.length.in_millimetres());
    p.tip_r_mm += correction.linear_mm + (chain_.r_from_t(to) * gauge - chain_.r_from_t(p.at) * gauge);
    p.at = to;
  }

  std::vector<ToolPosition> ideal() const {
    return recommanded([&](ToolPosition& p) {
      apply(p, ideal_correction(model_, chain_, machine_.limits, situation_at(p, piece_.tool.length, known_)));
    });
  }

  ScanSettings scan_settings() const {
    ScanSettings scan{.work_offsets_mm = job_.work_offsets_mm, .tcp = machine_.tcp == "on"};
    scan.letters[kTilt] = machine_.tilt_letter();
    // The planned program is written with its tip in W, whatever the machine's own programs do.
    if (o_.program.empty()) scan.tcp = scan.tcp_forced = true;
    return scan;
  }

  static OpenProgram opened(const std::string& text) {
    return [&text] {
      return [&text, at = std::size_t{0}](char* buffer, std::size_t size) mutable {
        const std::size_t taken = text.copy(buffer, size, at);
        at += taken;
        return taken;
      };
    };
  }

  /// Where a program puts the tool, read from its text.
  std::vector<ToolPosition> path_of(const std::string& program, const std::string& name) const {
    constexpr double kStep_mm = 0.1, kStep_deg = 0.1;
    const ScanSettings scan = scan_settings();
    const ModelField field(model_, job_.covariates, stroke());
    const Corrector nominal(chain_, field, settings(scan.tcp ? ToolCentrePoint::on : ToolCentrePoint::off));
    const Eigen::Isometry3d cone_from_w = w_from_cone(piece_.cone).inverse(Eigen::Isometry);
    std::vector<ToolPosition> path;
    for (const PlayedPlace& place : played_places(opened(program), scan, kStep_mm, kStep_deg)) {
      const Commanded commanded{{place.at[0], place.at[1], place.at[2]},
                                {Angle::degrees(place.at[kTilt]), Angle::degrees(place.at[kTurn])}};
      ToolPosition p{.at = commanded.rotary, .tip_r_mm = nominal.nominal_tip_r(commanded)};
      p.nominal.tip_w_mm = nominal.nominal_tip_w(commanded);
      p.nominal.axis_w =
          chain_.r_from_w(p.at).linear().transpose() * (chain_.r_from_t(p.at).linear() * Eigen::Vector3d::UnitZ());
      const Eigen::Vector3d in_cone =
          cone_from_w * (p.nominal.tip_w_mm + piece_.tool.overhang.in_millimetres() * p.nominal.axis_w);
      p.phi_rad = std::atan2(in_cone.y(), in_cone.x());
      path.push_back(p);
    }
    if (path.empty()) throw InputError(name, "no block that moves at feed with every axis known");
    set_senses(path, chain_, piece_.tool.length);
    return path;
  }

  Range<Angle> stroke() const {
    return machine_.tilt().range_angle.value_or(Range<Angle>{Angle::degrees(-180), Angle::degrees(180)});
  }

  CorrectionSettings settings(ToolCentrePoint tcp) const {
    return {.tcp = tcp,
            .largest_rotary_change = machine_.limits.rotary_word,
            .tool_length_mm = piece_.tool.length.in_millimetres()};
  }

  /// The text that `correct` would write.
  std::string corrected() const {
    const ModelField field(model_, job_.covariates, stroke());
    const Corrector with_tcp(chain_, field, settings(ToolCentrePoint::on));
    const Corrector without_tcp(chain_, field, settings(ToolCentrePoint::off));
    ProgramCorrection how;
    how.scan = scan_settings();
    how.guard = guard_of(machine_);
    how.name = o_.program.empty() ? "the planned program" : o_.program;
    how.header = "machine " + machine_.name + ", serial " + machine_.serial;
    std::string text;
    correct_program(
        opened(program_), [&](std::string_view part) { text += part; }, with_tcp, without_tcp, how);
    return text;
  }

  void read_covariates() {
    job_ = read_job(o_.job);
    for (const auto& [name, value] : job_.covariates) {
      if (name == "time_s") known_.time_s = value;
      if (name == "temperature_C") known_.temperature_C = value;
      names_.push_back(name);
      values_.push_back(value);
    }
    known_.extra = {&names_, values_.data()};
  }

  /// The tables of a folder, read back and played on the control that its verification.json names.
  std::vector<ToolPosition> under_tables() const {
    namespace fs = std::filesystem;
    if (!fs::is_directory(o_.tables)) throw InputError(o_.tables, "a folder written by trunnion tables is wanted");
    std::vector<TableFile> files;
    for (const auto& entry : fs::recursive_directory_iterator(o_.tables))
      if (entry.is_regular_file())
        files.push_back({fs::relative(entry.path(), o_.tables).generic_string(), read_text(entry.path().string())});
    std::ranges::sort(files, {}, &TableFile::name);
    const std::unique_ptr<PlayedCompensation> played = play_tables(files, machine_, model_);
    return recommanded([&](ToolPosition& p) { apply(p, played->at(situation_at(p, piece_.tool.length, known_))); });
  }

  void spread() {
    if (!model_.has_uncertainty() || o_.draws == 0) return;
    const DeviationSpread spread(piece_, surface_, planned_, chain_, model_, known_);
    if (spread.empty()) return;
    const bool visible = isatty(STDERR_FILENO) == 1 && !talk_.quiet;
    for (Cut& c : cuts_) {
      DrawOptions draw{.draws = o_.draws, .seed = o_.seed, .evaluation = evaluation_};
      if (visible)
        draw.progress = [&](double share) {
          std::fprintf(stderr, "\r%s: %3.0f %% of the draws", c.name.c_str(), 100 * share);
        };
      c.found.spread = spread.around(c.found.deviation_mm, draw);
      if (visible) std::fprintf(stderr, "\r%60s\r", "");
    }
  }

  const Cut& uncompensated() const { return cuts_.front(); }
  /// What was asked for: the compensated piece where there is one.
  const Cut& asked() const { return cuts_.size() > 1 ? cuts_[1] : cuts_[0]; }

  /// The whole flank for people's eyes: 21 heights, first order or envelope as the rest.
  void write_views(const Cut& c) {
    TestPiece shown = piece_;
    shown.heights.clear();
    for (int k = 0; k <= 20; ++k) shown.heights.push_back((k / 20.0) * piece_.cone.height);
    const SurfaceGrid surface = evaluated_surface(shown);
    std::vector<double> deviation;
    try {
      deviation = o_.first_order ? first_order_deviation_mm(shown, surface, c.path, c.tools)
                                 : envelope_deviation_mm(shown, surface, c.tools);
    } catch (const RangeError&) {
      return;  // a rounded tool leaves the lowest part of the flank: the evaluated heights alone are sure
    }
    output_.add("part_" + c.name + ".glb", part_glb(shown, surface, deviation, o_.magnify));
    output_.add("map_" + c.name + ".svg",
                unrolled_map_svg("Deviation of the flank, " + c.name, surface.phi_rad.size(), surface.h_mm, deviation));
  }

  void write() {
    output_.add("deviations.csv",
                deviations_text(surface_, asked().found, cuts_.size() > 1 ? &uncompensated().found : nullptr));
    for (const Cut& c : cuts_) write_views(c);
    if (o_.program.empty()) output_.add("program.ngc", program_);
    if (const std::string module = brep_module(); !module.empty())
      output_.add("part.step", piece_step(piece_, module));
    else
      talk_.warn("no part.step: this program was built without OpenCASCADE");
    if (o_.corrected) output_.add("program_corrected.ngc", corrected_program_);
    std::vector<std::vector<ConeTrace>> traces;
    for (const Cut& c : cuts_) traces.push_back(traces_of(piece_, surface_, c.found.deviation_mm));
    for (std::size_t j = 0; j < surface_.h_mm.size(); ++j) {
      std::vector<PolarCurve> curves;
      for (std::size_t k = 0; k < cuts_.size(); ++k)
        curves.push_back({cuts_[k].name, radial_trace(traces[k][j], piece_.cone.half_angle)});
      const std::string h = formatted("%g", surface_.h_mm[j]);
      output_.add("roundness_h" + h + ".svg", polar_plot_svg("Roundness at h = " + h + " mm", curves));
    }
    summary_ = {{"format", "trunnion-prediction"},
                {"version", 1},
                {"machine", {{"name", machine_.name}, {"serial", machine_.serial}}},
                {"method", o_.first_order ? "first order" : "envelope"},
                {"positions", path_.size()},
                {"notes", notes_}};
    if (evaluation_.filter_upr) summary_["filter_upr"] = *evaluation_.filter_upr;
    if (asked().found.spread) summary_["uncertainty"] = {{"draws", o_.draws}, {"seed", o_.seed}};
    for (const Cut& c : cuts_) {
      nlohmann::json entry = evaluation_json(piece_, surface_, c.found);
      const double before = uncompensated().found.evaluation.rms_mm;
      if (&c != &uncompensated() && before > 0) entry["share_removed"] = 1 - c.found.evaluation.rms_mm / before;
      summary_[c.name] = std::move(entry);
    }
    if (!o_.measured.empty())
      summary_["measured"] =
          evaluation_json(evaluate_cone(read_measured_piece(o_.measured, piece_), piece_.cone.half_angle, evaluation_));
    if (o_.sensitivity) {
      const EffectContext context = effect_context(machine_);
      const Angle steepest = machine_.tilt().range_angle
                                 ? std::min(-1.0 * machine_.tilt().range_angle->low, Angle::degrees(90))
                                 : Angle::degrees(90);
      const std::vector<Sensitivity> found = sensitivities(piece_, context);
      const BetterPiece better = better_piece(piece_, context, steepest);
      output_.add("sensitivity.json", sensitivity_json(found, better).dump(1) + "\n");
      talk_.show(sensitivity_text(found, better));
    }
    output_.add("prediction.json", summary_.dump(1) + "\n");
    output_.commit();
  }

  void show() const {
    std::vector<std::vector<std::string>> rows = {
        {"", "h mm", "LSC um", "MZC um", "MIC um", "MCC um", "centre um", "diameter mm"}};
    for (const Cut& c : cuts_)
      for (std::size_t j = 0; j < c.found.evaluation.heights.size(); ++j) {
        const HeightEvaluation& at = c.found.evaluation.heights[j];
        rows.push_back({j == 0 ? c.name : "", formatted("%g", at.h_mm),
                        c.found.spread ? with_uncertainty(1e3 * at.lsc_mm, 1e3 * c.found.spread->heights[j].lsc_mm.sd)
                                       : formatted("%.3f", 1e3 * at.lsc_mm),
                        formatted("%.3f", 1e3 * at.mzc_mm), formatted("%.3f", 1e3 * at.mic_mm),
                        formatted("%.3f", 1e3 * at.mcc_mm), formatted("%.2f", 1e3 * at.center_mm.norm()),
                        formatted("%.5f", at.diameter_mm)});
      }
    talk_.show(text_table(rows));
    for (const Cut& c : cuts_)
      talk_.show(c.name + ": rms " + formatted("%.3f um", 1e3 * c.found.evaluation.rms_mm) +
                 (c.found.evaluation.half_angle
                      ? ", half angle " + formatted("%.6f deg", c.found.evaluation.half_angle->in_degrees()) +
                            ", axis tilted " + formatted("%.1f urad", 1e6 * c.found.evaluation.axis_tilt_rad->norm())
                      : "") +
                 "\n");
    if (talk_.json) std::printf("%s\n", summary_.dump(1).c_str());
    talk_.say("wrote " + o_.output);
  }

  const Options& o_;
  const Talk& talk_;
  Machine machine_;
  Model model_;
  TestPiece piece_;
  KinematicChain chain_;
  SurfaceGrid surface_;
  OutputFolder output_;
  EvaluationOptions evaluation_;
  Job job_;
  Situation known_;  ///< what the job tells of the moment
  std::vector<std::string> names_;
  std::vector<double> values_;
  std::vector<ToolPosition> planned_;  ///< by the piece alone
  std::vector<ToolPosition> path_;     ///< as it is cut: planned, or the user's program
  std::string program_, corrected_program_;
  std::vector<Cut> cuts_;
  std::vector<std::string> notes_;
  nlohmann::json summary_;
};

}  // namespace

Command predict_command(CLI::App& program, const Talk& talk) {
  auto o = std::make_shared<Options>();
  CLI::App* app = program.add_subcommand(
      "predict", "What a coordinate measuring machine will find on a cone frustum cut on this machine");
  app->add_option("--machine", o->machine, "Machine file (TOML)")->required()->type_name("M.toml")->group("Input");
  app->add_option("--model", o->model, "Model (JSON)")->required()->type_name("model.json")->group("Input");
  app->add_option("--piece", o->piece, "Test piece (TOML)")->required()->type_name("P.toml")->group("Input");
  app->add_option("--program", o->program, "A program for the piece (LinuxCNC), instead of the planned path")
      ->type_name("N.nc")
      ->group("Input");
  app->add_option("--job", o->job, "Job: work offsets and covariates (TOML)")->type_name("J.toml")->group("Input");
  app->add_option("--measured", o->measured, "Evaluate a measured piece alike: phi_deg, h_mm, deviation_um (CSV)")
      ->type_name("T.csv")
      ->group("Input");
  CLI::Option* tables = app->add_option("--tables", o->tables, "Also as cut under the tables of this folder")
                            ->type_name("DIR")
                            ->group("Compensation");
  app->add_flag("--corrected", o->corrected, "Also as cut by the corrected program")
      ->excludes(tables)
      ->group("Compensation");
  app->add_option("-o,--output", o->output, "Folder of results")->required()->type_name("DIR")->group("Output");
  app->add_option("--magnify", o->magnify, "Draw the part's deviations this many times larger")
      ->check(CLI::Range(0.0, 1e6))
      ->group("Output");
  app->add_flag("--sensitivity", o->sensitivity, "Which errors this piece can see, and a piece that would see more")
      ->group("Evaluation");
  app->add_option("--filter", o->filter_upr, "Gaussian filter before evaluation, undulations per revolution (50, 15)")
      ->check(CLI::Range(1.0, 1e4))
      ->group("Evaluation");
  app->add_flag("--first-order", o->first_order, "To first order instead of the envelope of all tool positions")
      ->group("Evaluation");
  app->add_option("--steps", o->steps, "Tool positions per turn")->check(CLI::Range(360, 1000000))->group("Evaluation");
  app->add_option("--draws", o->draws, "Monte Carlo draws; 0: no uncertainty")
      ->check(CLI::Range(0, 1000000))
      ->group("Evaluation");
  app->add_option("--seed", o->seed, "Seed of the draws")->group("Evaluation");
  app->footer(
      "Example:\n  trunnion predict --machine machine.toml --model model.json --piece piece.toml --corrected -o piece");
  return {app, [o, &talk] { return Prediction(*o, talk).run(); }};
}

}  // namespace trunnion
