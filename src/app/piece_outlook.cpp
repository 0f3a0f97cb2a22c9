#include "app/piece_outlook.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/piece_cutting.h"
#include "app/text_table.h"
#include "error.h"
#include "io/piece_file.h"
#include "testpiece/cone_evaluation.h"
#include "testpiece/tool_path.h"

namespace trunnion {
nlohmann::json piece_outlook(const Machine& machine, const ClosureResult& result, const std::string& piece_file,
                             const std::string& job_file, std::vector<std::string>& inputs,
                             std::vector<std::string>& notes) {
  const TestPiece piece = read_piece(piece_file);
  const Job job = job_file.empty() ? Job{} : read_job(job_file);
  inputs.push_back(piece_file);
  if (!job_file.empty()) inputs.push_back(job_file);
  const KinematicChain chain(machine);
  const PieceCutting maps_alone(
      {.machine = machine, .model = result.bare_model, .piece = piece, .chain = chain, .job = job, .planned = true});
  const PieceCutting found(
      {.machine = machine, .model = result.model, .piece = piece, .chain = chain, .job = job, .planned = true});
  const std::vector<ToolPosition> path = flank_milling_path(piece, chain, {.steps_per_turn = kStepsPerTurn});
  for (const PieceCutting* cutting : {&maps_alone, &found})
    if (const auto beyond = cutting->beyond_reach(path)) throw RangeError(piece_file + ": " + *beyond);
  notes = found.unknown_moments();
  const SurfaceGrid surface = evaluated_surface(piece);
  const auto seen = [&](const PieceCutting& on, const std::vector<ToolPosition>& commanded) {
    const std::vector<double> left_mm = envelope_deviation_mm(piece, surface, on.actual(commanded));
    const ConeEvaluation cone = evaluate_cone(traces_of(piece, surface, left_mm), piece.cone.half_angle);
    double roundness_mm = 0;
    for (const HeightEvaluation& h : cone.heights) roundness_mm = std::max(roundness_mm, h.lsc_mm);
    return nlohmann::json{{"roundness_um", 1e3 * roundness_mm}, {"form_um", 1e3 * cone.form_mm}};
  };
  return {{"not_corrected", {{"before", seen(maps_alone, path)}, {"after", seen(found, path)}}},
          {"corrected",
           {{"before", seen(found, maps_alone.ideally_corrected(path))},
            {"after", seen(found, found.ideally_corrected(path))}}}};
}

std::string piece_outlook_text(const nlohmann::json& outlook) {
  std::vector<std::vector<std::string>> rows = {
      {"the frustum to be cut: roundness, largest (LSC)", "maps alone", "with what was found", ""}};
  for (const auto& [key, title] : {std::pair("not_corrected", "not corrected, as predicted by"),
                                   std::pair("corrected", "left after a correction by")}) {
    rows.push_back({title});
    for (const char* stage : {"before", "after"})
      rows.back().push_back(formatted("%.2f", outlook[key][stage]["roundness_um"].get<double>()));
    rows.back().emplace_back("um");
  }
  return "\n" + text_table(rows);
}

}  // namespace trunnion
