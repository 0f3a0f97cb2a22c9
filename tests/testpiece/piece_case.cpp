#include "testpiece/piece_case.h"

#include <algorithm>
#include <memory>

#include "identification/as_observations.h"
#include "io/piece_observations.h"
#include "support/probing_plan.h"
#include "support/smooth_machine.h"
#include "support/undeclared_effects.h"
#include "testpiece/cone_evaluation.h"
#include "testpiece/measured.h"
#include "testpiece/pieces.h"

namespace trunnion::testing {
namespace {

constexpr double kPieceSigma_mm = 0.2e-3, kProbeSigma_mm = 0.175e-3;

struct CutCone {
  TestPiece piece;
  KinematicChain chain{trunnion_machine()};
  std::vector<ToolPosition> path;
  SurfaceGrid surface;

  explicit CutCone(double tilt_deg) : piece(usual_piece(15, tilt_deg)) {
    piece.points = 180;
    piece.tool.length = Length::millimetres(120);
    piece.feed_mm_per_min = 400;
    path = flank_milling_path(piece, chain, {.steps_per_turn = 1800});
    surface = evaluated_surface(piece);
  }
  MeasuredPiece measured_on(const VirtualMachine& machine, Noise& noise) const {
    const std::vector<double> left = cut_by_brute_force(machine, piece, surface, path, [](MachineState&) {});
    return measured(surface, left,
                    {.sigma_mm = kPieceSigma_mm,
                     .shift_mm = {4e-3, -2e-3, 3e-3},
                     .turn_rad = {20e-6, 10e-6, -30e-6},
                     .grown_mm = 2e-3},
                    noise);
  }
};

/// One pass over the usual grid in which C turns on and on, by another turn at every tilt.
ProbingPlan onward_plan(Noise& noise) {
  ProbingPlan plan = two_top_plan();
  double tilt_deg = 0, turns_deg = 0;
  for (PlannedTouch& touch : plan.touches) {
    if (touch.A_deg != tilt_deg) tilt_deg = touch.A_deg, turns_deg += 360;
    touch.C_deg += turns_deg;
  }
  plan.faces = as_built(plan.faces, noise, 20e-3, 50e-6);
  return timed(std::move(plan));
}

double roundness_um(const ClosureResult& r, const std::vector<double>& residual, std::size_t first_row,
                    const PieceObservations& observed, const MeasuredPiece& found, const TestPiece& piece) {
  MeasuredPiece rest{.file = found.file};
  for (std::size_t i = 0; i < r.problem.readings.size(); ++i) {
    const std::size_t row = r.problem.readings[i].row;
    if (row < first_row) continue;
    rest.points.push_back(found.points[observed.point_of_row[row - first_row]]);
    rest.points.back().deviation_mm = residual[i];
  }
  double largest_mm = 0;
  for (const HeightEvaluation& h : evaluate_cone(traces_of(rest, piece), piece.cone.half_angle).heights)
    largest_mm = std::max(largest_mm, h.lsc_mm);
  return 1e3 * largest_mm;
}

}  // namespace

bool PieceOutcome::names_the_backlash() const {
  return std::ranges::any_of(closure.effects, [](const AcceptedEffect& e) {
    return e.effect->id() == "backlash:C" ||
           std::ranges::find(e.not_separable_from, "backlash:C") != e.not_separable_from.end();
  });
}

bool PieceOutcome::backlash_is_untestable() const {
  return std::ranges::any_of(closure.untestable,
                             [](const Untestable& u) { return u.id == "backlash:C" || u.id == "backlash"; });
}

PieceOutcome close_piece(const PieceCase& c) {
  VirtualMachine real = smooth_machine(c.seed, {.translation_mm = 1e-3, .rotation_rad = 8e-6, .C_harmonics = 1});
  if (c.backlash_rad != 0) add_rotary_backlash(real, 'C', c.backlash_rad);
  Machine machine = trunnion_machine();
  machine.probe.sigma = Length::millimetres(kProbeSigma_mm);

  Noise noise(7000 + c.seed);
  const CutCone cut(c.tilt_deg);
  const MeasuredPiece found = cut.measured_on(real, noise);
  const PieceObservations observed = observations_of({cut.piece, found, cut.path, cut.chain, {}});
  static std::vector<std::unique_ptr<ObservationSet>> kept;  // a result points into its observations
  const auto keep = [](ObservationSet set) -> const ObservationSet& {
    kept.push_back(std::make_unique<ObservationSet>(std::move(set)));
    return *kept.back();
  };
  PieceOutcome outcome;
  std::size_t first_row = 0;
  if (c.with_probing) {
    const ObservationSet& probing =
        keep(as_observations(probe(real, onward_plan(noise), {.sigma_mm = kProbeSigma_mm}, noise)));
    first_row = probing.rows.size();
    outcome.probing_alone = close_loop(probing, first_row, machine);
    outcome.closure = close_loop(keep(joined_with_piece(probing, observed.set)), first_row, machine);
  } else {
    const ObservationSet& alone = keep(observed.set);
    outcome.closure = close_loop(alone, alone.rows.size(), machine);
  }
  const ClosureResult& r = outcome.closure;
  outcome.roundness_before_um = roundness_um(r, r.residual_before, first_row, observed, found, cut.piece);
  outcome.roundness_after_um = roundness_um(r, r.residual_after, first_row, observed, found, cut.piece);
  return outcome;
}

}  // namespace trunnion::testing
