#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "error.h"
#include "geometric_errors/symbol.h"
#include "io/job_file.h"
#include "io/machine_file.h"
#include "io/model_file.h"
#include "io/observation_file.h"
#include "io/output_file.h"
#include "io/piece_file.h"
#include "model/effects/rotary_error_map.h"
#include "python/arrays.h"
#include "python/bindings.h"

namespace trunnion::python {
namespace {

using std::filesystem::path;

std::string quoted(const std::string& text) { return "'" + text + "'"; }

const RotaryErrorMap& map_of(const Model& model) {
  const RotaryErrorMap* map = model.rotary_map();
  if (map == nullptr) throw ModelError("this model holds no rotary_error_map");
  return *map;
}

/// Stations as people say them: what lies within 1e-11 deg of a millionth is that millionth, -60 and not
/// -59.99999999999999.
Numbers degrees(const std::vector<Angle>& angles) {
  Numbers array(static_cast<py::ssize_t>(angles.size()));
  auto out = array.mutable_unchecked<1>();
  for (py::ssize_t i = 0; i < array.size(); ++i) {
    const double degrees = angles[static_cast<std::size_t>(i)].in_degrees(), round = std::round(1e6 * degrees) / 1e6;
    out(i) = std::abs(degrees - round) < 1e-11 ? round : degrees;
  }
  return array;
}

/// What `value(coefficient, unit)` says of every node of one error: (n_A,) for the tilting axis, (n_A, n_C) for C.
template <class Value>
Numbers of_symbol(const RotaryErrorMap& map, const std::string& symbol, Value value) {
  const ErrorGrid& grid = map.content().grid;
  const auto n_a = static_cast<py::ssize_t>(grid.a_stations.size()),
             n_c = static_cast<py::ssize_t>(grid.c_stations.size());
  const std::size_t component = symbol.size() == 3 && symbol[0] == 'E' ? kComponentLetters.find(symbol[1]) : 6;
  if (component >= 6 || (symbol[2] != 'A' && symbol[2] != 'B' && symbol[2] != 'C'))
    throw UsageError("symbol: " + symbol + " found, EXA ... ECC is wanted");
  const Unit unit = component_unit(component);
  if (symbol[2] != 'C') {
    const std::vector<std::string> columns = map.depends_on();
    if (std::ranges::find(columns, symbol.substr(2) + "_deg") == columns.end())
      throw UsageError("symbol: " + symbol + " is of no axis of this machine");
    Numbers array(n_a);
    auto out = array.mutable_unchecked<1>();
    for (py::ssize_t i = 0; i < n_a; ++i)
      out(i) = value(grid.tilt_offset(static_cast<std::size_t>(i)) + component, unit);
    return array;
  }
  Numbers array({n_a, n_c});
  auto out = array.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < n_a; ++i)
    for (py::ssize_t j = 0; j < n_c; ++j)
      out(i, j) = value(grid.turn_offset(static_cast<std::size_t>(i), static_cast<std::size_t>(j)) + component, unit);
  return array;
}

Numbers error(const Model& model, const std::string& symbol) {
  const RotaryErrorMap& map = map_of(model);
  const Eigen::VectorXd values = map.content().grid.coefficients();
  return of_symbol(map, symbol,
                   [&](std::size_t k, Unit unit) { return to_unit(values[static_cast<Eigen::Index>(k)], unit); });
}

py::object std_of(const Model& model, const std::string& symbol) {
  const RotaryErrorMap& map = map_of(model);
  const Eigen::MatrixXd& covariance = map.content().grid_covariance;
  if (covariance.size() == 0) return py::none();
  return of_symbol(map, symbol, [&](std::size_t k, Unit unit) {
    const auto i = static_cast<Eigen::Index>(k);
    return to_unit(std::sqrt(covariance(i, i)), unit);
  });
}

py::list effect_dicts(const Model& model) {
  py::list list;
  for (const EffectPtr& effect : model.effects) list.append(from_json(effect->to_json()));
  return list;
}

void bind_machine(py::module_& module) {
  py::class_<Machine, std::shared_ptr<Machine>>(module, "Machine",
                                                "A five-axis machine as its file (TOML) describes it")
      .def(py::init([](const path& file) { return read_machine(file.string()); }), py::arg("path"),
           "Reads a machine file. Raises InputError with file and line, what was found and what is wanted.")
      .def_static(
          "parse", [](const std::string& text, const std::string& name) { return parse_machine(text, name); },
          py::arg("text"), py::arg("name") = "machine.toml", "The same from text; name stands for it in messages")
      .def_readonly("name", &Machine::name)
      .def_readonly("serial", &Machine::serial)
      .def_readonly("controller", &Machine::controller, "As the file says it; empty where it does not")
      .def_property_readonly(
          "tilt", [](const Machine& m) { return std::string(1, m.tilt_letter()); },
          "Letter of the tilting axis: A or B")
      .def_property_readonly(
          "structure", [](const Machine& m) { return m.structure.code; }, "After ISO 10791-6, from workpiece to tool")
      .def_property_readonly(
          "probe_sigma_um", [](const Machine& m) { return m.probe.sigma.in_micrometres(); },
          "Standard deviation of one touch, um")
      .def("__repr__",
           [](const Machine& m) { return "<trunnion.Machine " + quoted(m.name) + ", serial " + m.serial + ">"; });
}

void bind_model(py::module_& module) {
  py::class_<Model>(module, "Model",
                    "What can be wrong with one machine: a list of effects, the rotary error map first")
      .def(py::init([](const path& file, const Machine& machine) {
             Model model = read_model(file.string(), machine);
             check_same_machine(model, machine, file.string());
             return model;
           }),
           py::arg("path"), py::arg("machine"),
           "Reads a model file (JSON) of this machine. Raises InputError for what a model must not say, RefusalError "
           "for "
           "another machine's model.")
      .def_static(
          "parse",
          [](const std::string& text, const Machine& machine, const std::string& name) {
            Model model = parse_model(text, name, machine);
            check_same_machine(model, machine, name);
            return model;
          },
          py::arg("text"), py::arg("machine"), py::arg("name") = "model.json", "The same from text")
      .def_property_readonly("text", &model_text, "The text of its file")
      .def(
          "save", [](const Model& model, const path& file) { write_whole(file.string(), model_text(model), {}); },
          py::arg("path"), "Writes its file, whole or not at all")
      .def_property_readonly(
          "ids",
          [](const Model& model) {
            std::vector<std::string> ids;
            for (const EffectPtr& effect : model.effects) ids.push_back(effect->id());
            return ids;
          },
          "The effects by family or family:detail")
      .def_property_readonly("effects", &effect_dicts, "The effects as the file tells them, one dict each")
      .def_property_readonly(
          "fit", [](const Model& model) { return model.fit ? from_json(*model.fit) : py::none(); },
          "How it was found, a dict; None where the file does not say")
      .def_property_readonly(
          "tilt_deg", [](const Model& model) { return degrees(map_of(model).content().grid.a_stations); },
          "Stations of the tilting axis, deg, shape (n_A,)")
      .def_property_readonly(
          "turn_deg", [](const Model& model) { return degrees(map_of(model).content().grid.c_stations); },
          "Stations of C, deg, shape (n_C,)")
      .def("error", &error, py::arg("symbol"),
           "One error function at the stations: um for EX. EY. EZ., urad for EA. EB. EC.; shape (n_A,) for the tilting "
           "axis (EXA ... ECA), (n_A, n_C) for C (EXC ... ECC)")
      .def("std", &std_of, py::arg("symbol"),
           "Its standard uncertainty, alike in shape and unit; None where the model has none")
      .def_property_readonly("has_uncertainty", &Model::has_uncertainty)
      .def_property_readonly("needs", &needed_covariates,
                             "Covariates beyond position that effects of the machine depend on: time_s, A_dir ...")
      .def("__repr__", [](const Model& model) {
        return "<trunnion.Model of " + quoted(model.machine.name) + ", serial " + model.machine.serial + ", " +
               std::to_string(model.effects.size()) + " effects>";
      });
}

using Set = std::shared_ptr<ObservationSet>;

/// A property of every row, seen in place; `first` points into the first row.
template <class First>
py::cpp_function column(First first) {
  return [first](const py::object& self) {
    const auto& rows = self.cast<const ObservationSet&>().rows;
    return rows.empty() ? py::array(Numbers(0))
                        : view(first(rows.front()), static_cast<py::ssize_t>(rows.size()), sizeof(Observation), self);
  };
}
template <class First>
py::cpp_function column3(First first) {
  return [first](const py::object& self) {
    const auto& rows = self.cast<const ObservationSet&>().rows;
    return rows.empty() ? py::array(Numbers(std::vector<py::ssize_t>{0, 3}))
                        : view3(first(rows.front()), static_cast<py::ssize_t>(rows.size()), sizeof(Observation), self);
  };
}

static_assert(sizeof(Angle) == sizeof(double));
const double* in_place(const Angle& angle) { return reinterpret_cast<const double*>(&angle); }

void bind_observations(py::module_& module) {
  py::class_<ObservationSet, Set>(
      module, "Observations",
      "Readings in the order taken. Its arrays are views of one memory, read only, in the inside units mm and rad.")
      .def(py::init([](const path& file, const Machine& machine) {
             return std::make_shared<ObservationSet>(read_observations(file.string(), machine));
           }),
           py::arg("path"), py::arg("machine"),
           "Reads an observations file (CSV) of this machine. Raises InputError with file, line and column.")
      .def_static(
          "parse",
          [](const std::string& text, const Machine& machine, const std::string& name) {
            return std::make_shared<ObservationSet>(parse_observations(text, name, machine));
          },
          py::arg("text"), py::arg("machine"), py::arg("name") = "observations.csv", "The same from text")
      .def("__len__", [](const ObservationSet& set) { return set.rows.size(); })
      .def_property_readonly("tilt_rad", column([](const Observation& o) { return in_place(o.at.a); }),
                             "Commanded tilt, rad, shape (n,)")
      .def_property_readonly("turn_rad", column([](const Observation& o) { return in_place(o.at.c); }),
                             "Commanded turn of C, rad, shape (n,)")
      .def_property_readonly("position_mm", column3([](const Observation& o) { return o.position_mm.data(); }),
                             "Contact point, or the ball's nominal place, in R, mm, shape (n, 3)")
      .def_property_readonly("direction", column3([](const Observation& o) { return o.direction.data(); }),
                             "Unit vector of approach or sensing, or axis of a rotation, in R, shape (n, 3)")
      .def_property_readonly("value", column([](const Observation& o) { return &o.value; }),
                             "displacement: mm, rotation: rad, contact: 0, shape (n,)")
      .def_property_readonly("time_s", column([](const Observation& o) { return &o.time_s; }), "s, shape (n,)")
      .def_property_readonly("temperature_C", column([](const Observation& o) { return &o.temperature_C; }),
                             "deg C, shape (n,)")
      .def_property_readonly(
          "point",
          [](const ObservationSet& set) {
            py::list labels;
            for (const Observation& o : set.rows)
              labels.append(o.point < set.points.size() ? set.points[o.point] : std::string());
            return labels;
          },
          "Label of the probed spot of every row")
      .def("__repr__", [](const ObservationSet& set) {
        return "<trunnion.Observations, " + std::to_string(set.rows.size()) + " rows>";
      });
}

}  // namespace

py::object from_json(const nlohmann::json& json) { return py::module_::import("json").attr("loads")(json.dump()); }

void bind_values(py::module_& module) {
  bind_machine(module);
  bind_model(module);
  bind_observations(module);
  py::class_<TestPiece>(module, "Piece", "A test piece: a cone frustum, its tool and path (TOML)")
      .def(py::init([](const path& file) { return read_piece(file.string()); }), py::arg("path"))
      .def_static(
          "parse", [](const std::string& text, const std::string& name) { return parse_piece(text, name); },
          py::arg("text"), py::arg("name") = "piece.toml")
      .def_property_readonly("text", &piece_text, "The text of its file");
  py::class_<Job>(module, "Job", "What a program is run with: work offsets, tools, covariates (TOML)")
      .def(py::init([](const path& file) { return read_job(file.string()); }), py::arg("path"))
      .def_static(
          "parse", [](const std::string& text, const std::string& name) { return parse_job(text, name); },
          py::arg("text"), py::arg("name") = "job.toml")
      .def_readonly("covariates", &Job::covariates, "Values for effects that need them, by column")
      .def_readonly("work_offsets_mm", &Job::work_offsets_mm, "[x, y, z] by code: G54");
}

}  // namespace trunnion::python
