#include "app/piece_closure.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/piece_cutting.h"
#include "app/program_reading.h"
#include "error.h"
#include "io/csv.h"
#include "io/piece_file.h"
#include "io/text_file.h"
#include "testpiece/cone_evaluation.h"
#include "testpiece/tool_path.h"

namespace trunnion {

CutPiece read_cut_piece(const PieceFiles& files, std::vector<std::string>& inputs) {
  CutPiece cut{.piece = read_piece(files.piece), .name = files.piece, .program_name = files.program};
  cut.measured = read_measured_piece(files.measured, cut.piece);
  if (!files.job.empty()) cut.job = read_job(files.job);
  if (!files.program.empty()) cut.program = read_text(files.program);
  for (const std::string* file : {&files.piece, &files.measured, &files.program, &files.job})
    if (!file->empty()) inputs.push_back(*file);
  return cut;
}

PieceClosure::PieceClosure(CutPiece cut, const Machine& machine)
    : piece_(std::move(cut.piece)), measured_(std::move(cut.measured)) {
  const Model nothing;
  const KinematicChain chain(machine);
  CuttingSetup setup{machine, nothing, piece_, chain, cut.job};
  setup.planned = cut.program.empty();
  if (const std::string told = dialect_of(cut.program, machine); !setup.planned && !told.empty()) setup.dialect = told;
  const PieceCutting cutting(setup);
  const std::vector<ToolPosition> path = setup.planned
                                             ? flank_milling_path(piece_, chain, {.steps_per_turn = kStepsPerTurn})
                                             : cutting.path_of(cut.program, cut.program_name);
  if (const auto beyond = cutting.beyond_reach(path)) throw RangeError(cut.name + ": " + *beyond);
  observations_ = observations_of({piece_, measured_, path, chain, cutting.known()});
  // The job's covariates end here; their values stand in the readings.
}

nlohmann::json PieceClosure::left(const ClosureResult& result, const std::vector<double>& residual,
                                  std::size_t first_row) const {
  MeasuredPiece rest{.file = measured_.file};
  double sum = 0;
  for (std::size_t i = 0; i < result.problem.readings.size(); ++i) {
    const std::size_t row = result.problem.readings[i].row;
    if (row < first_row || std::ranges::find(result.outliers, i) != result.outliers.end()) continue;
    rest.points.push_back(measured_.points[observations_.point_of_row[row - first_row]]);
    rest.points.back().deviation_mm = residual[i];
    sum += residual[i] * residual[i];
  }
  nlohmann::json json = {
      {"rms_um", 1e3 * std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, rest.points.size())))},
      {"roundness_um", nullptr}};
  try {
    double roundness_mm = 0;
    for (const HeightEvaluation& h : evaluate_cone(traces_of(rest, piece_), piece_.cone.half_angle).heights)
      roundness_mm = std::max(roundness_mm, h.lsc_mm);
    json["roundness_um"] = 1e3 * roundness_mm;
  } catch (const InputError&) {  // too few points are left at a height
  }
  return json;
}

nlohmann::json PieceClosure::json(const ClosureResult& result, std::size_t first_row) const {
  return {{"before", left(result, result.residual_before, first_row)},
          {"after", left(result, result.residual_after, first_row)},
          {"points", observations_.set.rows.size()},
          {"unsteady", observations_.unsteady},
          {"sigma_um", 1e3 * observations_.sigma_mm}};
}

std::string PieceClosure::csv(const ClosureResult& result, std::size_t first_row) const {
  std::string text = "phi_deg,h_mm,measured_um,predicted_before_um,predicted_after_um\n";
  for (std::size_t i = 0; i < result.problem.readings.size(); ++i) {
    const std::size_t row = result.problem.readings[i].row;
    if (row < first_row) continue;
    const MeasuredPoint& point = measured_.points[observations_.point_of_row[row - first_row]];
    append_number(text, point.phi.in_degrees());
    for (const double value :
         {point.h.in_millimetres(), 1e3 * point.deviation_mm, 1e3 * (point.deviation_mm - result.residual_before[i]),
          1e3 * (point.deviation_mm - result.residual_after[i])}) {
      text += ',';
      append_number(text, value);
    }
    text += '\n';
  }
  return text;
}

}  // namespace trunnion
