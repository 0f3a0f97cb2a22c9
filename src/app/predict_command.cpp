#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/changed_inputs.h"
#include "app/command.h"
#include "app/piece_cutting.h"
#include "app/prediction_text.h"
#include "app/program_reading.h"
#include "app/progress.h"
#include "app/text_table.h"
#include "error.h"
#include "io/machine_file.h"
#include "io/model_file.h"
#include "io/output_file.h"
#include "io/piece_file.h"
#include "io/provenance.h"
#include "io/text_file.h"
#include "postproc/dialect.h"
#include "testpiece/colour_scale.h"
#include "testpiece/part_view.h"
#include "testpiece/piece_solid.h"
#include "testpiece/plots.h"

namespace trunnion {
namespace predict_cli {
namespace {

constexpr int kViewHeights = 21;

bool same_height(double a_mm, double b_mm) { return std::abs(a_mm - b_mm) < 1e-6; }

struct Options {
  std::string machine, model, piece, program, dialect, job, measured, tables, output;
  bool corrected = false, first_order = false, sensitivity = false;
  double filter_upr = 0, magnify = 0;
  int draws = 2000;
  std::uint64_t seed = 1;
  int steps = kStepsPerTurn;
};

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
        output_(o_.output, inputs()),
        job_(o_.job.empty() ? Job{} : read_job(o_.job)),
        program_(o_.program.empty() ? "" : read_text(o_.program)),
        dialect_(dialect_of_programs()),
        cutting_({machine_, model_, piece_, chain_, job_, dialect_, o_.program.empty()}),
        brep_(brep_module()) {
    if (o_.filter_upr > 0) evaluation_.filter_upr = o_.filter_upr;
    if (!o_.measured.empty()) measured_ = traces_of(read_measured_piece(o_.measured, piece_), piece_);
  }

  int run() {
    if (o_.first_order && (!o_.program.empty() || o_.corrected))
      throw UsageError("--first-order: it takes the planned path; programs are cut by the envelope");
    for (const std::string& line : changed_inputs(model_, o_.model, {o_.machine})) talk_.warn(line);
    if (!o_.tables.empty())
      for (const std::string& line : changed_since_verified(o_.tables, {o_.machine, o_.model})) talk_.warn(line);
    lay_path();
    if (const auto beyond = cutting_.beyond_reach(path_)) throw RangeError(o_.piece + ": " + *beyond);
    notes_ = cutting_.unknown_moments();
    for (const std::string& note : notes_) talk_.warn(note);
    cut("uncompensated", path_);
    if (!o_.tables.empty()) cut("tables", cutting_.under_tables(path_, o_.tables));
    if (o_.corrected) {
      corrected_ = cutting_.corrected(program_, o_.program.empty() ? "the planned program" : o_.program);
      asked_ = pieces_.size();
      cut("corrected", corrected_.path);
    }
    if (pieces_.size() > 1) cut("ideal", cutting_.ideally_corrected(path_));
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

  /// The path along the solid's own surface, or that of the user's program.
  void lay_path() {
    if (o_.program.empty()) {
      path_ = flank_milling_path(piece_, chain_, {.steps_per_turn = o_.steps},
                                 brep_.empty() ? Rulings() : solid_rulings(piece_, brep_));
      program_ = cutting_.planned_program(path_);
    } else {
      path_ = cutting_.path_of(program_, o_.program);
    }
  }

  /// Of the program given, or of the one to be written: LinuxCNC's where the machine's control has none of its own.
  std::string dialect_of_programs() const {
    if (!o_.dialect.empty()) return o_.dialect;
    const std::string told = dialect_of(program_, machine_);
    if (told.empty() && !o_.program.empty())
      throw UsageError(o_.program +
                       ": its dialect is not told by the program nor by the machine's controller; --dialect is wanted");
    return told.empty() ? "linuxcnc" : told;
  }

  std::vector<double> deviation_mm(const TestPiece& piece, const SurfaceGrid& surface,
                                   const std::vector<ToolPosition>& path,
                                   const std::vector<ToolInWorkpiece>& tools) const {
    return o_.first_order ? first_order_deviation_mm(piece, surface, path, tools)
                          : envelope_deviation_mm(piece, surface, tools);
  }

  /// The piece as cut along `path`, and how it looks.
  void cut(const std::string& name, const std::vector<ToolPosition>& path) {
    const Progress progress(talk_, "cut " + name);
    const std::vector<ToolInWorkpiece> tools = cutting_.actual(path);
    PredictedPiece made{.name = name, .deviation_mm = deviation_mm(piece_, surface_, path, tools)};
    made.evaluation =
        evaluate_cone(traces_of(piece_, surface_, made.deviation_mm), piece_.cone.half_angle, evaluation_);
    pieces_.push_back(std::move(made));
    cut_flank(name, path, tools);
  }

  /// The whole flank for people's eyes.
  void cut_flank(const std::string& name, const std::vector<ToolPosition>& path,
                 const std::vector<ToolInWorkpiece>& tools) {
    TestPiece shown = piece_;
    shown.heights.clear();
    for (int k = 0; k < kViewHeights; ++k) shown.heights.push_back((k / (kViewHeights - 1.0)) * piece_.cone.height);
    const SurfaceGrid surface = evaluated_surface(shown);
    std::vector<double> deviation;
    try {
      deviation = deviation_mm(shown, surface, path, tools);
    } catch (const RangeError&) {
      return;  // a rounded tool leaves the lowest part of the flank: the evaluated heights alone are sure
    }
    flanks_.push_back({name, std::move(deviation)});
    flank_ = surface;
  }

  /// Every flank in the colours of one scale, so that before and after can be compared.
  void draw_flanks() {
    double largest_mm = 0;
    for (const CutFlank& flank : flanks_)
      for (const double d : flank.deviation_mm) largest_mm = std::max(largest_mm, std::abs(d));
    const double end_um = round_scale(1e3 * largest_mm);
    for (const CutFlank& flank : flanks_) {
      output_.add("part_" + flank.name + ".glb", part_glb(piece_, flank_, flank.deviation_mm, end_um, o_.magnify));
      output_.add("map_" + flank.name + ".svg",
                  unrolled_map_svg("Deviation of the flank, " + flank.name, flank_.phi_rad.size(), flank_.h_mm,
                                   flank.deviation_mm, end_um));
    }
  }

  void spread() {
    if (!model_.has_uncertainty() || o_.draws == 0) return;
    const DeviationSpread spread(piece_, surface_, path_, chain_, model_, cutting_.known());
    if (spread.empty()) return;
    for (PredictedPiece& p : pieces_) {
      Progress progress(talk_, "draws of " + p.name, o_.draws, "draws");
      p.spread = spread.around(p.deviation_mm, {.draws = o_.draws,
                                                .seed = o_.seed,
                                                .progress = [&](double share) { progress.at(share * o_.draws); },
                                                .evaluation = evaluation_});
    }
  }

  void write() {
    output_.add("deviations.csv", deviations_text(surface_, pieces_, asked()));
    if (!flanks_.empty()) output_.add("flank.csv", flank_text(flank_, flanks_));
    const std::string suffix(dialect(dialect_).suffix);
    if (o_.program.empty()) output_.add("program" + suffix, program_);
    if (o_.corrected) output_.add("program_corrected" + suffix, corrected_.text);
    if (!brep_.empty())
      output_.add("part.step", piece_step(piece_, brep_));
    else
      talk_.warn("no part.step: this program was built without OpenCASCADE");
    draw_flanks();
    draw_roundness();
    if (o_.sensitivity) judge_piece();
    summarise();
    output_.add("prediction.json", summary_.dump(1) + "\n");
    output_.commit();
  }

  void draw_roundness() {
    const std::string filtered =
        evaluation_.filter_upr ? ", " + formatted("%g", *evaluation_.filter_upr) + " UPR filter" : "";
    std::vector<double> heights = surface_.h_mm;  // and those that were measured besides
    for (const ConeTrace& trace : measured_)
      if (std::ranges::none_of(heights, [&](double h) { return same_height(h, trace.h_mm); }))
        heights.push_back(trace.h_mm);
    for (const double height : heights) {
      std::vector<PolarCurve> curves;
      const auto add = [&](const std::string& name, std::span<const ConeTrace> traces) {
        for (const ConeTrace& trace : traces)
          if (same_height(trace.h_mm, height))
            curves.push_back({name, radial_trace(trace, piece_.cone.half_angle, evaluation_)});
      };
      for (const PredictedPiece& p : pieces_) add(p.name, traces_of(piece_, surface_, p.deviation_mm));
      add("measured", measured_);
      const std::string h = formatted("%g", height);
      output_.add("roundness_h" + h + ".svg", polar_plot_svg("Roundness at h = " + h + " mm" + filtered, curves));
    }
  }

  void judge_piece() {
    const EffectContext context = effect_context(machine_);
    const std::vector<Sensitivity> found = sensitivities(piece_, context);
    std::optional<Progress> progress(std::in_place, talk_, "a better piece");
    const BetterPiece better =
        better_piece(piece_, context, [&](std::span<const ToolPosition> path) { return !cutting_.beyond_reach(path); });
    progress.reset();
    output_.add("better_piece.toml", piece_text(better.piece));
    output_.add("sensitivity.json", sensitivity_json(found, better).dump(1) + "\n");
    talk_.show(sensitivity_text(found, better));
  }

  /// What was asked for: the piece with its program corrected, else under tables, else as the machine is.
  std::size_t asked() const { return asked_ > 0 ? asked_ : std::min<std::size_t>(1, pieces_.size() - 1); }

  std::optional<ConeEvaluation> evaluated_measurement() const {
    if (measured_.empty()) return std::nullopt;
    return evaluate_cone(measured_, piece_.cone.half_angle, evaluation_);
  }

  void summarise() {
    summary_ = {{"format", "trunnion-prediction"},
                {"version", 1},
                {"machine", {{"name", machine_.name}, {"serial", machine_.serial}}},
                {"piece", piece_json(piece_)},
                {"method", o_.first_order ? "first order" : "envelope"},
                {"dialect", dialect_},
                {"positions", path_.size()},
                {"notes", notes_}};
    summary_.update(provenance_json(inputs()));
    if (evaluation_.filter_upr) summary_["filter_upr"] = *evaluation_.filter_upr;
    if (pieces_.front().spread) summary_["uncertainty"] = {{"draws", o_.draws}, {"seed", o_.seed}};
    for (const PredictedPiece& p : pieces_) {
      nlohmann::json entry = evaluation_json(piece_, surface_, p);
      if (&p != &pieces_.front())
        entry["removed"] = removed_json(removed_shares(piece_, pieces_.front().evaluation, p.evaluation));
      summary_[p.name] = std::move(entry);
    }
    if (const auto measured = evaluated_measurement())
      summary_["measured"] = evaluation_json(piece_, measured_, *measured);
  }

  void show() const {
    talk_.show(prediction_text(piece_, pieces_, evaluated_measurement()));
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
  Job job_;
  std::string program_, dialect_;
  PieceCutting cutting_;
  std::string brep_;  ///< the solid modeller; empty: none
  EvaluationOptions evaluation_;
  std::vector<ToolPosition> path_;
  CorrectedPieceProgram corrected_;
  std::vector<PredictedPiece> pieces_;
  std::size_t asked_ = 0;
  SurfaceGrid flank_;  ///< the whole flank, and how it was cut
  std::vector<CutFlank> flanks_;
  std::vector<ConeTrace> measured_;
  std::vector<std::string> notes_;
  nlohmann::json summary_;
};

}  // namespace
}  // namespace predict_cli

Command predict_command(CLI::App& program, const Talk& talk) {
  using namespace predict_cli;
  auto o = std::make_shared<Options>();
  CLI::App* app = program.add_subcommand(
      "predict", "What a coordinate measuring machine will find on a cone frustum cut on this machine");
  app->add_option("--machine", o->machine, "Machine file (TOML)")->required()->type_name("M.toml")->group("Input");
  app->add_option("--model", o->model, "Model (JSON)")->required()->type_name("model.json")->group("Input");
  app->add_option("--piece", o->piece, "Test piece (TOML)")->required()->type_name("P.toml")->group("Input");
  app->add_option("--program", o->program, "A program for the piece, instead of the planned path")
      ->type_name("N.nc")
      ->group("Input");
  app->add_option("--dialect", o->dialect,
                  "Dialect of the program, given or written; default: told by it or by the machine's controller")
      ->check(CLI::IsMember(dialect_names()))
      ->group("Input");
  app->add_option("--job", o->job, "Job: work offsets and covariates (TOML)")->type_name("J.toml")->group("Input");
  app->add_option("--measured", o->measured, "Evaluate a measured piece alike: phi_deg, h_mm, deviation_um (CSV)")
      ->type_name("T.csv")
      ->group("Input");
  app->add_option("--tables", o->tables, "Also as cut under the tables of this folder")
      ->type_name("DIR")
      ->group("Compensation");
  app->add_flag("--corrected", o->corrected, "Also as cut by the corrected program")->group("Compensation");
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
      "With --tables and --corrected deviations.csv speaks of the corrected program; the others stand beside it.\n"
      "Example:\n  trunnion predict --machine machine.toml --model model.json --piece piece.toml --corrected -o piece");
  return {app, [o, &talk] { return Prediction(*o, talk).run(); }};
}

}  // namespace trunnion
