#include "discovery/closure.h"

#include <nlohmann/json.hpp>

#include "app/piece_closure.h"
#include "error.h"
#include "io/closure_file.h"
#include "io/observed_ranges.h"
#include "io/piece_file.h"
#include "io/piece_observations.h"
#include "python/active.h"
#include "python/arrays.h"
#include "python/bindings.h"

namespace trunnion::python {
namespace {

using nlohmann::json;
using Readings = std::shared_ptr<const ObservationSet>;
using Path = std::filesystem::path;

struct Closure {
  Readings all;  ///< to which the result points
  ClosureResult result;
  json summary;
};

/// A piece that was cut and measured; nothing where none is given.
std::optional<PieceClosure> piece_closure(const Machine& machine, const TestPiece* piece, const Path& measured,
                                          const std::string& program, const Job* job) {
  if (piece == nullptr && measured.empty() && program.empty() && job == nullptr) return std::nullopt;
  if (piece == nullptr || measured.empty()) throw UsageError("piece, measured: both are wanted, or neither");
  CutPiece cut{.piece = *piece, .measured = read_measured_piece(measured.string(), *piece), .program = program};
  if (job != nullptr) cut.job = *job;
  return PieceClosure(std::move(cut), machine);
}

Closure run_close(const Machine& machine, const Readings& observations, const Readings& verification,
                  const Active& active, const std::string& active_only, const TestPiece* piece, const Path& measured,
                  const std::string& program, const Job* job) {
  if (!observations && piece == nullptr) throw UsageError("observations: wanted, or piece and measured");
  if (!active_only.empty() && active_only != "observations" && active_only != "verification")
    throw UsageError("active_only: observations or verification is wanted");
  const auto bare = [&](const Readings& set, const char* role) {
    const bool counts = active && (active_only.empty() || active_only == role);
    return counts ? *without(active, *set, machine) : *set;
  };
  ObservationSet all;
  if (observations) all = bare(observations, "observations");
  std::size_t calibration_rows = all.rows.size();
  if (verification) all = joined(all, bare(verification, "verification"));
  const std::size_t piece_row = all.rows.size();
  const std::optional<PieceClosure> cut = piece_closure(machine, piece, measured, program, job);
  if (cut) {
    all = all.rows.empty() ? cut->observations().set : joined_with_piece(all, cut->observations().set);
    if (!observations) calibration_rows = all.rows.size();
  }
  const auto readings = std::make_shared<const ObservationSet>(std::move(all));
  Closure closure{readings, close_loop(*readings, calibration_rows, machine), {}};
  closure.summary = closure_json(closure.result);
  if (cut) closure.summary["piece"] = cut->json(closure.result, piece_row);
  closure.result.model.fit = std::make_shared<json>(json{{"method", "closure"},
                                                         {"verdict", closure.summary["verdict"]},
                                                         {"before", closure.summary["before"]},
                                                         {"after", closure.summary["after"]},
                                                         {"observed", observed_json(*readings)}});
  return closure;
}

template <std::vector<double> ClosureResult::*Residual>
py::array residual(const py::object& self) {
  const std::vector<double>& values = self.cast<const Closure&>().result.*Residual;
  return view(values.data(), static_cast<py::ssize_t>(values.size()), sizeof(double), self);
}

}  // namespace

void bind_closure(py::module_& module) {
  py::class_<Closure>(module, "Closure", "What close() found")
      .def_property_readonly("verdict", [](const Closure& c) { return std::string(verdict_text(c.result.verdict)); })
      .def_property_readonly(
          "model", [](const Closure& c) { return c.result.model; }, "The extended model")
      .def_property_readonly(
          "summary", [](const Closure& c) { return from_json(c.summary); },
          "closure.json as a dict: effects with their evidence, stages before and after, the piece if there is one")
      .def_property_readonly("residual_before", &residual<&ClosureResult::residual_before>,
                             "Residuals without the effects found, mm (rad for rotations), shape (readings,); a view")
      .def_property_readonly("residual_after", &residual<&ClosureResult::residual_after>, "The same with them");
  module.def(
      "close", &run_close, py::call_guard<py::gil_scoped_release>(), py::arg("machine"),
      py::arg("observations") = nullptr, py::arg("verification") = nullptr, py::kw_only(),
      py::arg("active") = std::nullopt, py::arg("active_only") = "", py::arg("piece") = nullptr,
      py::arg("measured") = "", py::arg("program") = "", py::arg("job") = nullptr,
      "Looks for effects that the data show and the map lacks. verification: a later measurement at other angles, "
      "part of which is kept back. active: the compensation that was switched on while measuring, a Model, Tables, or "
      "the path of either; active_only: observations or verification, which of the two was measured with it. piece: a "
      "Piece that was cut on the machine, measured: the CSV file of what was measured of it (deg, mm, um); program: "
      "the "
      "text that cut it, job: its Job; without a program, the planned path. observations may be missing beside a "
      "piece. Raises RefusalError for another machine's compensation or program.");
}

}  // namespace trunnion::python
