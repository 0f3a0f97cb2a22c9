#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/correction_report.h"
#include "app/piece_cutting.h"
#include "app/prior_map.h"
#include "app/program_setup.h"
#include "compensation/verification.h"
#include "error.h"
#include "io/identification_report.h"
#include "io/machine_file.h"
#include "io/model_file.h"
#include "io/observed_ranges.h"
#include "io/output_file.h"
#include "io/prediction_file.h"
#include "model/effects/rotary_error_map.h"
#include "postproc/dialect.h"
#include "python/active.h"
#include "python/arrays.h"
#include "python/bindings.h"

namespace trunnion::python {
namespace {

using nlohmann::json;
using Readings = std::shared_ptr<const ObservationSet>;

// ---- identify

struct Identification {
  Readings observations;  ///< to which the result points
  IdentificationResult result;
  json summary;
};

Identification run_identify(const Machine& machine, Readings observations, const Active& active,
                            const std::string& method, bool robust, bool fill, const std::string& interpolation,
                            const Model* prior, std::optional<double> drift_um, std::optional<double> drift_urad) {
  if (method != "joint" && method != "two-step")
    throw UsageError("method: " + method + " found, joint or two-step is wanted");
  IdentificationOptions options{.robust = robust, .fill = fill, .interpolation = interpolation};
  options.method = method == "two-step" ? IdentificationMethod::two_step : IdentificationMethod::joint;
  if (prior != nullptr) options.earlier = prior_map(*prior, "prior", drift_um, drift_urad).earlier;
  if (active) observations = without(active, *observations, machine);
  Identification found{observations, identify(*observations, machine, options), {}};
  found.summary = identification_json(found.result, machine, {});
  found.summary["observed"] = observed_json(*observations);
  found.result.model.fit = std::make_shared<json>(found.summary);
  return found;
}

// ---- evaluate

struct Evaluation {
  Numbers deviation_um, table_error;
  py::object sd_um = py::none();
  py::array_t<bool> extrapolated;
};

/// One number for all rows, or one for each: element `i` of what broadcasts.
class Column {
 public:
  Column(const Numbers& numbers, const std::string& name) : numbers_(numbers), name_(name) {
    if (numbers.ndim() > 1) throw UsageError(name + ": an array of one dimension is wanted");
  }
  py::ssize_t size() const { return numbers_.ndim() == 0 ? 1 : numbers_.shape(0); }
  double at(py::ssize_t i) const {
    const double value = numbers_.ndim() == 0 ? *numbers_.data() : *numbers_.data(size() == 1 ? 0 : i);
    if (!std::isfinite(value)) throw UsageError(name_ + "[" + std::to_string(i) + "]: a finite number is wanted");
    return value;
  }

 private:
  Numbers numbers_;
  std::string name_;
};

/// Where the machine stands in every row.
class Positions {
 public:
  Positions(const Machine& machine, const Numbers& tilt_deg, const Numbers& turn_deg, const Numbers& point_mm,
            const std::map<std::string, Numbers>& covariates, ObservedRanges observed)
      : tilt_name_(std::string(1, machine.tilt_letter()) + "_deg"),
        tilt_(tilt_deg, tilt_name_),
        turn_(turn_deg, "C_deg"),
        point_(point_mm),
        observed_(std::move(observed)) {
    if (point_.ndim() < 1 || point_.ndim() > 2 || point_.shape(point_.ndim() - 1) != 3)
      throw UsageError("point_mm: shape (3,) or (n, 3) is wanted");
    for (const auto& [name, numbers] : covariates) {
      names_.push_back(name);
      columns_.emplace_back(numbers, name);
    }
    values_.resize(names_.size());
    rows_ = point_.ndim() == 2 ? point_.shape(0) : 1;
    std::vector<py::ssize_t> sizes = {tilt_.size(), turn_.size()};
    for (const Column& column : columns_) sizes.push_back(column.size());
    for (const py::ssize_t size : sizes) rows_ = rows_ == 1 ? size : rows_;
    for (const py::ssize_t size : sizes)
      if (size != rows_ && size != 1)
        throw UsageError("lengths " + std::to_string(size) + " and " + std::to_string(rows_) +
                         " found, one for all rows or one for each is wanted");
    if (point_.ndim() == 2 && point_.shape(0) != rows_ && point_.shape(0) != 1)
      throw UsageError("point_mm: one row for all, or one for each is wanted");
    tilt_dir_ = std::string(1, machine.tilt_letter()) + "_dir";
  }

  py::ssize_t rows() const { return rows_; }
  bool has(const std::string& covariate) const { return std::ranges::find(names_, covariate) != names_.end(); }
  const std::string& tilt_name() const { return tilt_name_; }

  /// The situation of row `i`; valid until the next is asked for.
  Situation at(py::ssize_t i) {
    Situation s;
    s.at = {Angle::degrees(tilt_.at(i)), Angle::degrees(turn_.at(i))};
    for (py::ssize_t k = 0; k < 3; ++k) {
      s.point_r_mm[k] = point_.ndim() == 1 ? *point_.data(k) : *point_.data(point_.shape(0) == 1 ? 0 : i, k);
      if (!std::isfinite(s.point_r_mm[k])) throw UsageError("point_mm: a finite number is wanted");
    }
    for (std::size_t c = 0; c < names_.size(); ++c) {
      const double value = values_[c] = held(observed_, names_[c], columns_[c].at(i));
      if (names_[c] == "time_s") s.time_s = value;
      if (names_[c] == "temperature_C") s.temperature_C = value;
      if (names_[c] != tilt_dir_ && names_[c] != "C_dir") continue;
      if (value != 1 && value != -1) throw UsageError(names_[c] + ": +1 or -1 is wanted");
      (names_[c] == "C_dir" ? s.turn_sense : s.tilt_sense) = static_cast<int>(value);
    }
    s.extra = {&names_, values_.data()};
    return s;
  }

 private:
  std::string tilt_name_, tilt_dir_;
  Column tilt_, turn_;
  Numbers point_;
  ObservedRanges observed_;
  std::vector<std::string> names_;
  std::vector<Column> columns_;
  std::vector<double> values_;
  py::ssize_t rows_ = 1;
};

Evaluation run_evaluate(const Machine& machine, const Model& model, const Numbers& tilt_deg, const Numbers& turn_deg,
                        const Numbers& point_mm, const std::map<std::string, Numbers>& covariates, bool hold) {
  Positions positions(machine, tilt_deg, turn_deg, point_mm, covariates, observed_ranges(model));
  for (const std::string& column : needed_covariates(model))
    if (!positions.has(column)) warn("no " + column + ", which the model needs: its effects stand at their zero");
  const py::ssize_t n = positions.rows();
  Evaluation result{.deviation_um = Numbers({n, py::ssize_t{3}}), .table_error = Numbers({n, py::ssize_t{6}})};
  result.extrapolated = py::array_t<bool>(n);
  const bool uncertain = model.has_uncertainty();
  Numbers sd(uncertain ? std::vector<py::ssize_t>{n, 3} : std::vector<py::ssize_t>{0, 3});
  auto deviation = result.deviation_um.mutable_unchecked<2>(), table = result.table_error.mutable_unchecked<2>();
  auto sd_um = sd.mutable_unchecked<2>();
  auto extrapolated = result.extrapolated.mutable_unchecked<1>();
  const RotaryErrorMap* map = model.rotary_map();
  for (py::ssize_t i = 0; i < n; ++i) {
    Situation s = positions.at(i);
    extrapolated(i) = map != nullptr && !map->surface().covers(s.at.a);
    if (extrapolated(i)) {
      if (!hold)
        throw RangeError(positions.tilt_name() + "[" + std::to_string(i) +
                         "]: outside the tilts that were "
                         "probed; hold=True takes the end");
      const Range<Angle> range = map->surface().a_range();
      s.at.a = std::clamp(s.at.a, range.low, range.high);
    }
    const Eigen::Vector3d d = deviation_mm(model, s);
    const PoseError e = table_error(model, s);
    for (py::ssize_t k = 0; k < 3; ++k) {
      deviation(i, k) = 1e3 * d[k];
      table(i, k) = 1e3 * e.translation_mm[k];
      table(i, k + 3) = 1e6 * e.rotation_rad[k];
    }
    if (!uncertain) continue;
    const Eigen::Vector3d variance = deviation_covariance_mm2(model, s).diagonal().cwiseMax(0);
    for (py::ssize_t k = 0; k < 3; ++k) sd_um(i, k) = 1e3 * std::sqrt(variance[k]);
  }
  if (uncertain) result.sd_um = std::move(sd);
  return result;
}

// ---- correct

struct Correction {
  std::string program;
  json report;
  std::vector<std::string> notes;
};

Correction run_correct(const Machine& machine, const Model& model, const std::string& program, const Job* job,
                       const ProgramChoices& choices) {
  check_same_machine(model, machine, "model");
  ProgramSetup setup(machine, model, job != nullptr ? *job : Job{}, choices, program, "program", model_text(model));
  setup.how().keep_insertions = true;
  Correction corrected{.notes = setup.notes()};
  if (job == nullptr) corrected.notes.emplace_back("no job: work offsets are zero");
  const ProgramCorrectionResult result = correct_program(
      opened(program), [&](std::string_view text) { corrected.program += text; }, setup.with_tcp(), setup.without_tcp(),
      setup.how());
  std::optional<PlaybackResult> played;
  if (result.refusals.empty())
    played = play_back(opened(program), opened(corrected.program), setup.with_tcp(), setup.how(), result);
  corrected.report = correction_json("program", choices.orientation, setup.how(), result, played);
  if (played && !setup.holds(*played) && result.counts.beyond_tolerance == 0)
    throw RefusalError("program:" + std::to_string(played->after.tip_line) +
                       ": played back, the tip does not hold the tolerance");
  return corrected;
}

// ---- tables

Tables run_tables(const Machine& machine, const Model& model, const std::string& controller, double spacing_deg,
                  double tool_length_mm, const std::string& date) {
  check_same_machine(model, machine, "model");
  const std::string name = controller.empty() ? machine.controller : controller;
  if (name.empty()) throw UsageError("controller: missing, and the machine file names none");
  if (spacing_deg != 0 && !(spacing_deg >= 0.1 && spacing_deg <= 90))
    throw UsageError("spacing_deg: 0.1 to 90 deg is wanted");
  if (std::ranges::any_of(date, [](char c) { return static_cast<unsigned char>(c) < ' '; }))
    throw UsageError("date: one line of text is wanted");
  TableOptions options{.date = date, .tool_length = Length::millimetres(tool_length_mm)};
  options.turn_spacing = options.tilt_spacing = Angle::degrees(spacing_deg);
  Tables tables{make_tables(controller_named(name), machine, model, options), {}};
  for (const TableFile& file : tables.set.files)
    if (file.name == "verification.json") tables.verification = std::make_shared<const json>(json::parse(file.text));
  return tables;
}

// ---- predict

struct Prediction {
  SurfaceGrid surface;
  std::vector<PredictedPiece> pieces;
  std::string program, corrected_program;
  json summary;
};

Prediction run_predict(const Machine& machine, const Model& model, const TestPiece& piece,
                       const std::string& tables_folder, bool corrected, const Job* job, int draws,
                       std::uint64_t seed) {
  check_same_machine(model, machine, "model");
  const Job no_job;
  const KinematicChain chain(machine);
  const PieceCutting cutting({.machine = machine,
                              .model = model,
                              .piece = piece,
                              .chain = chain,
                              .job = job != nullptr ? *job : no_job,
                              .planned = true});
  Prediction p{.surface = evaluated_surface(piece)};
  const std::vector<ToolPosition> path = flank_milling_path(piece, chain);
  if (const auto beyond = cutting.beyond_reach(path)) throw RangeError("piece: " + *beyond);
  p.program = cutting.planned_program(path);
  const DeviationSpread spread(piece, p.surface, path, chain, model, cutting.known());
  const auto cut = [&](const std::string& name, const std::vector<ToolPosition>& way) {
    PredictedPiece made{.name = name, .deviation_mm = envelope_deviation_mm(piece, p.surface, cutting.actual(way))};
    made.evaluation = evaluate_cone(traces_of(piece, p.surface, made.deviation_mm), piece.cone.half_angle);
    if (draws > 0 && model.has_uncertainty() && !spread.empty())
      made.spread = spread.around(made.deviation_mm, {.draws = draws, .seed = seed});
    p.summary[name] = evaluation_json(piece, p.surface, made);
    p.pieces.push_back(std::move(made));
  };
  cut("uncompensated", path);
  if (!tables_folder.empty()) cut("tables", cutting.under_tables(path, tables_folder));
  if (corrected) {
    CorrectedPieceProgram made = cutting.corrected(p.program, "the planned program");
    p.corrected_program = std::move(made.text);
    cut("corrected", made.path);
  }
  return p;
}

/// Degrees of the evaluated points about the cone's axis.
Numbers phi_deg(const Prediction& p) {
  Numbers array(static_cast<py::ssize_t>(p.surface.phi_rad.size()));
  auto out = array.mutable_unchecked<1>();
  for (py::ssize_t i = 0; i < array.size(); ++i)
    out(i) = Angle::radians(p.surface.phi_rad[static_cast<std::size_t>(i)]).in_degrees();
  return array;
}

py::dict deviations(const py::object& self) {
  const auto& p = self.cast<const Prediction&>();
  const auto heights = static_cast<py::ssize_t>(p.surface.h_mm.size()),
             points = static_cast<py::ssize_t>(p.surface.phi_rad.size());
  py::dict by_name;
  for (const PredictedPiece& piece : p.pieces) {
    Numbers array({heights, points});
    std::ranges::transform(piece.deviation_mm, array.mutable_data(), [](double mm) { return 1e3 * mm; });
    by_name[py::str(piece.name)] = array;
  }
  return by_name;
}

void bind_results(py::module_& module) {
  py::class_<Identification>(module, "Identification", "What identify() found")
      .def_property_readonly(
          "model", [](const Identification& i) { return i.result.model; }, "The rotary error map alone")
      .def_property_readonly(
          "summary", [](const Identification& i) { return from_json(i.summary); },
          "What `trunnion identify --json` prints, a dict: noise against declaration, rank, outliers, every error "
          "against zero, location errors, evidence for the interpolation")
      .def_property_readonly("sigma_found_um", [](const Identification& i) { return i.result.sigma_found_um; })
      .def_property_readonly("reduced_chi_square", [](const Identification& i) { return i.result.reduced_chi_square; })
      .def_property_readonly("freedom", [](const Identification& i) { return i.result.freedom; })
      .def_property_readonly("readings", [](const Identification& i) { return i.result.readings; })
      .def_property_readonly("rank", [](const Identification& i) { return i.result.rank; });
  py::class_<Evaluation>(module, "Evaluation", "The model at n positions")
      .def_readonly("deviation_um", &Evaluation::deviation_um,
                    "Workpiece point minus tool point in R, to be added to the command, um, shape (n, 3)")
      .def_readonly("table_error", &Evaluation::table_error,
                    "The table's pose error at R's origin: Dx Dy Dz um, Da Db Dc urad, shape (n, 6)")
      .def_readonly("sd_um", &Evaluation::sd_um,
                    "Standard uncertainty of the deviation, um, shape (n, 3); None where the model has none")
      .def_readonly("extrapolated", &Evaluation::extrapolated,
                    "Whether the end of the probed tilts was held, shape (n,)");
  py::class_<Correction>(module, "Correction", "A corrected NC program")
      .def_property_readonly(
          "program", [](const Correction& c) { return py::bytes(c.program); }, "Its bytes")
      .def_property_readonly(
          "report", [](const Correction& c) { return from_json(c.report); },
          "What was changed, and the program played back before and after, a dict")
      .def_readonly("notes", &Correction::notes, "What the job leaves open, in sentences");
  py::class_<Tables>(module, "Tables", "A controller's compensation files, read back and verified")
      .def_property_readonly(
          "files",
          [](const Tables& t) {
            py::dict files;
            for (const TableFile& file : t.set.files) files[py::str(file.name)] = file.text;
            return files;
          },
          "Text by name; *.DRAFT.* where the machine's [profile] leaves a question open")
      .def_property_readonly(
          "verification", [](const Tables& t) { return from_json(*t.verification); }, "verification.json as a dict")
      .def_property_readonly("load_ready", [](const Tables& t) { return t.set.verification.load_ready(); })
      .def(
          "write",
          [](const Tables& t, const std::filesystem::path& folder) {
            OutputFolder output(folder.string(), {});
            for (const TableFile& file : t.set.files) output.add(file.name, file.text);
            output.commit();
          },
          py::arg("folder"), "Writes the files, all or none");
  py::class_<Prediction>(module, "Prediction", "What a coordinate measuring machine will find on a piece")
      .def_property_readonly("phi_deg", &phi_deg, "About the cone's axis, deg, shape (n_phi,)")
      .def_property_readonly(
          "h_mm",
          [](const py::object& self) {
            const auto& h = self.cast<const Prediction&>().surface.h_mm;
            return view(h.data(), static_cast<py::ssize_t>(h.size()), sizeof(double), self);
          },
          "Heights along the axis from the base, mm, shape (n_h,)")
      .def_property_readonly("deviation_um", &deviations,
                             "Excess material along the outward normal, um, shape (n_h, n_phi), by way of cutting: "
                             "uncompensated, tables, corrected")
      .def_property_readonly(
          "summary", [](const Prediction& p) { return from_json(p.summary); },
          "Roundness, centre, size, cone angle, axis tilt by way of cutting, as in prediction.json")
      .def_readonly("program", &Prediction::program, "The planned program for LinuxCNC")
      .def_readonly("corrected_program", &Prediction::corrected_program, "Empty unless asked for");
}

using NoPython = py::call_guard<py::gil_scoped_release>;

}  // namespace

void bind_tasks(py::module_& module) {
  bind_results(module);
  const py::kw_only keys;
  module.def(
      "identify", &run_identify, NoPython(), py::arg("machine"), py::arg("observations"), keys,
      py::arg("active") = std::nullopt, py::arg("method") = "joint", py::arg("robust") = true, py::arg("fill") = false,
      py::arg("interpolation") = "", py::arg("prior") = nullptr, py::arg("drift_um") = std::nullopt,
      py::arg("drift_urad") = std::nullopt,
      "Error maps with standard uncertainties from measurements. method: joint (one least squares over all poses) or "
      "two-step (pose by pose, as the paper). interpolation: a method's name; empty: what predicts left-out angles "
      "best. prior: an earlier model of this machine, believed as far as the drift (1 sigma, um and urad) allows. "
      "active: "
      "the compensation that was switched on while measuring, a Model, Tables, or the path of either; the readings are "
      "taken back to the bare machine's.");
  module.def(
      "evaluate", &run_evaluate, py::arg("machine"), py::arg("model"), py::arg("tilt_deg"), py::arg("turn_deg"),
      py::arg("point_mm"), keys, py::arg("covariates") = std::map<std::string, Numbers>(), py::arg("hold") = false,
      "The model at n positions. tilt_deg, turn_deg: commanded angles, deg, one for all or shape (n,). point_mm: the "
      "nominal tool point in R, mm, shape (3,) or (n, 3). covariates: by column (time_s s, temperature_C deg C, A_dir "
      "and C_dir +1 or -1, ...), alike in shape. hold: outside the probed tilts take the end instead of raising "
      "RangeError. Arrays of float64 are read in place.");
  module.def(
      "correct",
      [](const Machine& machine, const Model& model, const std::string& program, const Job* job,
         const std::string& dialect, const std::string& tcp, bool orientation, int decimals, double tolerance_um,
         bool keep_going, int threads) {
        const auto known = dialect_names();
        if (!dialect.empty() && std::ranges::find(known, dialect) == known.end())
          throw UsageError("dialect: " + dialect + " is not known");
        if (tcp != "auto" && tcp != "on" && tcp != "off") throw UsageError("tcp: auto, on or off is wanted");
        if (decimals < 2 || decimals > 6) throw UsageError("decimals: 2 to 6 are wanted");
        if (threads < 1 || threads > 64) throw UsageError("threads: 1 to 64 are wanted");
        if (!(tolerance_um >= 0.01 && tolerance_um <= 1000)) throw UsageError("tolerance_um: 0.01 to 1000 is wanted");
        return run_correct(machine, model, program, job,
                           {.dialect = dialect,
                            .tcp = tcp,
                            .orientation = orientation,
                            .decimals = decimals,
                            .threads = threads,
                            .tolerance_um = tolerance_um,
                            .keep_going = keep_going});
      },
      NoPython(), py::arg("machine"), py::arg("model"), py::arg("program"), py::arg("job") = nullptr, keys,
      py::arg("dialect") = "", py::arg("tcp") = "auto", py::arg("orientation") = true, py::arg("decimals") = 4,
      py::arg("tolerance_um") = 0.2, py::arg("keep_going") = false, py::arg("threads") = 2,
      "An NC program (text or bytes) with corrected positions and orientations, and played back. dialect: told by the "
      "program or the machine's controller where it is empty. tcp: auto, on (X Y Z turn with the table) or off. "
      "tolerance_um: tip error allowed between end points. Raises RefusalError or RangeError for the first block that "
      "is "
      "refused, unless keep_going copies it.");
  module.def(
      "tables", &run_tables, NoPython(), py::arg("machine"), py::arg("model"), py::arg("controller") = "", keys,
      py::arg("spacing_deg") = 0, py::arg("tool_length_mm") = 0, py::arg("date") = "",
      "The compensation files of a controller (linuxcnc, sinumerik-840d, isg-twincat, heidenhain, fanuc-30i, "
      "aerotech; empty: the machine file's), projected, read back, played and judged. spacing_deg: distance of "
      "nodes; 0: chosen for the error. Raises RangeError beyond a limit, RefusalError where the machine would not "
      "become better.");
  module.def(
      "predict",
      [](const Machine& machine, const Model& model, const TestPiece& piece, const std::filesystem::path& tables,
         bool corrected, const Job* job, int draws, std::uint64_t seed) {
        if (draws < 0 || draws > 1000000) throw UsageError("draws: 0 to 1000000 are wanted");
        return run_predict(machine, model, piece, tables.string(), corrected, job, draws, seed);
      },
      NoPython(), py::arg("machine"), py::arg("model"), py::arg("piece"), keys, py::arg("tables") = "",
      py::arg("corrected") = false, py::arg("job") = nullptr, py::arg("draws") = 0, py::arg("seed") = 1,
      "The deviations of a test piece cut on this machine: uncompensated, under the tables of a folder, by the "
      "corrected program. draws: Monte Carlo draws of the uncertainty, from seed; 0: none.");
}

}  // namespace trunnion::python
