#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "app/changed_inputs.h"
#include "app/command.h"
#include "app/progress.h"
#include "app/text_table.h"
#include "error.h"
#include "io/csv.h"
#include "io/machine_file.h"
#include "io/model_file.h"
#include "io/observed_ranges.h"
#include "io/output_file.h"
#include "io/text_file.h"
#include "model/effects/rotary_error_map.h"
#include "units/nearest_name.h"

namespace trunnion {
namespace evaluate_cli {
namespace {

struct Options {
  std::string machine, model, positions, output, extrapolate;
};

/// The columns of the positions file that say where and in what state.
class PositionReader {
 public:
  PositionReader(std::string_view text, const std::string& name, const Machine& machine, const Model& model)
      : csv_(text, name), tilt_(1, machine.tilt_letter()), observed_(observed_ranges(model)) {
    const auto wanted = [&](const std::string& column) {
      const auto found = csv_.find(column);
      if (!found)
        throw InputError(name, csv_.line(),
                         "header: column " + column + " is missing; the nearest there is \"" +
                             nearest_name(column, csv_.header()) + "\"");
      return *found;
    };
    a_ = wanted(tilt_ + "_deg");
    c_ = wanted("C_deg");
    x_ = wanted("x_mm");
    y_ = wanted("y_mm");
    z_ = wanted("z_mm");
    for (const std::string& column : needed_covariates(model)) {
      if (const auto found = csv_.find(column))
        covariates_.emplace_back(column, *found);
      else
        missing_.push_back(column);
    }
    for (const auto& [column, index] : covariates_) extra_names_.push_back(column), (void)index;
    extra_values_.resize(extra_names_.size());
  }

  bool next(Situation& s) {
    if (!csv_.next(fields_)) return false;
    const auto number = [&](std::size_t column) { return csv_.number(fields_[column], column); };
    s = Situation{};
    s.at = {Angle::degrees(number(a_)), Angle::degrees(number(c_))};
    s.point_r_mm = {number(x_), number(y_), number(z_)};
    for (std::size_t k = 0; k < covariates_.size(); ++k) {
      const auto& [column, index] = covariates_[k];
      if (fields_[index].empty()) {  // not known: the effect stands at its zero
        blank_.insert(column);
        extra_values_[k] = 0;
        continue;
      }
      const double told = number(index), value = held(observed_, column, told);
      if (value != told) held_.insert(column);
      extra_values_[k] = value;
      if (column == "time_s") s.time_s = value;
      if (column == "temperature_C") s.temperature_C = value;
      if (column == tilt_ + "_dir" || column == "C_dir") {
        if (value != 1 && value != -1)
          throw InputError(csv_.name(), csv_.line(),
                           column + ": " + std::string(fields_[index]) + " found, +1 or -1 is wanted");
        (column == "C_dir" ? s.turn_sense : s.tilt_sense) = static_cast<int>(value);
      }
    }
    s.extra = {&extra_names_, extra_values_.data()};
    return true;
  }

  const CsvReader& csv() const { return csv_; }
  const std::vector<std::string>& missing() const { return missing_; }
  /// Covariates that were blank in some row, and those beyond what was observed in some row.
  const std::set<std::string>& blank() const { return blank_; }
  const std::set<std::string>& held_at_end() const { return held_; }
  std::string tilt_text() const { return std::string(fields_[a_]); }

 private:
  CsvReader csv_;
  std::string tilt_;
  ObservedRanges observed_;
  std::set<std::string> blank_, held_;
  std::size_t a_ = 0, c_ = 0, x_ = 0, y_ = 0, z_ = 0;
  std::vector<std::pair<std::string, std::size_t>> covariates_;
  std::vector<std::string> missing_, extra_names_;
  std::vector<double> extra_values_;
  std::vector<std::string_view> fields_;
};

struct Evaluated {
  PoseError table;
  Eigen::Vector3d deviation_mm;
};

/// Both sums in one pass over the effects; a RangeError gets the place it came from.
Evaluated evaluated(const Model& model, const Situation& s, const CsvReader& csv) try {
  PoseError table, relative;
  for (const EffectPtr& effect : model.effects) {
    if (!effect->is_compensated()) continue;
    const PoseError error = effect->at(s);
    relative += error;
    if (effect->moves_table()) table += error;
  }
  return {table, displacement_mm(relative, s.point_r_mm)};
} catch (const RangeError& e) {
  throw RangeError(csv.name() + ":" + std::to_string(csv.line()) + ": " + e.what());
}

int run(const Options& o, const Talk& talk) {
  if (talk.json && o.output == "-") throw UsageError("--json and -o - both write to standard output");
  const Machine machine = read_machine(o.machine);
  const Model model = read_model(o.model, machine);
  for (const std::string& line : changed_inputs(model, o.model, {o.machine})) talk.warn(line);
  const std::string text = read_text(o.positions);
  PositionReader positions(text, o.positions, machine, model);
  const RotaryErrorMap* map = model.rotary_map();
  const bool hold = o.extrapolate == "hold", uncertain = model.has_uncertainty();
  OutputFile output(o.output, {o.machine, o.model, o.positions});
  std::vector<std::string> results = {"dx_um", "dy_um",   "dz_um",   "Dx_um",  "Dy_um",
                                      "Dz_um", "Da_urad", "Db_urad", "Dc_urad"};
  if (uncertain) results.insert(results.end(), {"sdx_um", "sdy_um", "sdz_um", "sd_um"});
  if (hold) results.emplace_back("extrapolated");
  std::string line;
  for (const std::string& column : positions.csv().header()) line += (line.empty() ? "" : ",") + column;
  for (const std::string& column : results) {
    if (positions.csv().find(column))
      throw InputError(o.positions, positions.csv().line(),
                       "header: column " + column + " found, which is a result; positions must not have it");
    line += "," + column;
  }
  output.append(line + "\n");
  for (const std::string& column : positions.missing())
    talk.warn(o.positions + ": no column " + column + ", which the model needs: its effects stand at their zero");

  Situation s;
  std::size_t rows = 0, held = 0;
  double largest = 0;
  {
    Progress progress(talk, "evaluate", static_cast<double>(std::ranges::count(text, '\n')), "rows");
    while (positions.next(s)) {
      bool extrapolated = false;
      if (map != nullptr && !map->surface().covers(s.at.a)) {
        const Range<Angle> range = map->surface().a_range();
        if (!hold)
          throw RangeError(o.positions + ":" + std::to_string(positions.csv().line()) + ": " + machine.tilt_letter() +
                           "_deg: " + positions.tilt_text() + " found, the map was measured from " +
                           formatted("%.6g", range.low.in_degrees()) + " to " +
                           formatted("%.6g", range.high.in_degrees()) + "; --extrapolate hold takes the end");
        s.at.a = std::clamp(s.at.a, range.low, range.high);
        extrapolated = true;
        ++held;
      }
      const auto [table, d] = evaluated(model, s, positions.csv());
      largest = std::max(largest, d.norm());
      line.assign(positions.csv().row_text());
      const auto append = [&](double value) {
        line += ',';
        append_number(line, value);
      };
      for (Eigen::Index k = 0; k < 3; ++k) append(1e3 * d[k]);
      for (Eigen::Index k = 0; k < 3; ++k) append(1e3 * table.translation_mm[k]);
      for (Eigen::Index k = 0; k < 3; ++k) append(1e6 * table.rotation_rad[k]);
      if (uncertain) {
        const Eigen::Vector3d variance = deviation_covariance_mm2(model, s).diagonal().cwiseMax(0);
        for (Eigen::Index k = 0; k < 3; ++k) append(1e3 * std::sqrt(variance[k]));
        append(1e3 * std::sqrt(variance.sum()));
      }
      if (hold) line += extrapolated ? ",1" : ",0";
      output.append(line + "\n");
      progress.at(static_cast<double>(++rows));
    }
  }
  output.commit();
  for (const std::string& column : positions.blank())
    talk.warn(o.positions + ": " + column + " is blank in some rows: its effects stand at their zero there");
  for (const std::string& column : positions.held_at_end())
    talk.warn(o.positions + ": " + column + " goes beyond what was observed: its effects are held at the end there");
  if (held > 0)
    talk.warn(std::to_string(held) +
              " rows lie outside the probed tilt; the map's end was held for them (column extrapolated)");
  if (talk.json) {
    const nlohmann::json summary = {{"rows", rows},
                                    {"extrapolated", held},
                                    {"largest_deviation_um", 1e3 * largest},
                                    {"at_zero_for_want_of", positions.missing()},
                                    {"blank", positions.blank()},
                                    {"held", positions.held_at_end()},
                                    {"uncertainty", uncertain}};
    std::printf("%s\n", summary.dump(1).c_str());
  }
  if (o.output == "-") return 0;
  talk.show(std::to_string(rows) + " positions, largest deviation " + formatted("%.3f um\n", 1e3 * largest));
  talk.say("wrote " + o.output);
  return 0;
}

}  // namespace
}  // namespace evaluate_cli

Command evaluate_command(CLI::App& program, const Talk& talk) {
  using namespace evaluate_cli;
  auto o = std::make_shared<Options>();
  CLI::App* app = program.add_subcommand("evaluate", "The deviation and the table's pose error at given positions");
  app->add_option("--machine", o->machine, "Machine file (TOML)")->required()->type_name("M.toml")->group("Input");
  app->add_option("--model", o->model, "Model (JSON)")->required()->type_name("model.json")->group("Input");
  app->add_option("--at", o->positions, "Positions: A_deg, C_deg, x_mm, y_mm, z_mm and covariates (CSV)")
      ->required()
      ->type_name("P.csv")
      ->group("Input");
  app->add_option("-o,--output", o->output, "Positions with deviations to write (CSV)")
      ->required()
      ->type_name("D.csv")
      ->group("Output");
  app->add_option("--extrapolate", o->extrapolate, "hold: outside the probed tilt take the end's value, flagged")
      ->check(CLI::IsMember({"hold"}))
      ->group("Evaluation");
  app->footer(
      "Example:\n  trunnion evaluate --machine machine.toml --model model.json --at positions.csv -o deviations.csv");
  return {app, [o, &talk] { return run(*o, talk); }};
}

}  // namespace trunnion
