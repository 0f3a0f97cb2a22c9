#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>

#include "model/effects/rotary_error_map.h"
#include "support/noise.h"
#include "testpiece/pieces.h"
#include "testpiece/prediction_spread.h"

// The machined surface at full size, and a prediction's Monte Carlo, on all processors.

namespace trunnion {
namespace {

constexpr int kSteps = 100000;
constexpr std::size_t kAround = 4000, kHeights = 250;

RotaryMapContent uncertain_map() {
  testing::Noise noise(1);
  std::vector<Angle> a, c;
  for (const double v : {-90.0, -60.0, -30.0, 0.0}) a.push_back(Angle::degrees(v));
  for (int k = 0; k < 6; ++k) c.push_back(Angle::degrees(60 * k));
  RotaryMapContent content{.grid = zero_grid(a, c), .full_covariance = true};
  Eigen::VectorXd values = content.grid.coefficients();
  Eigen::VectorXd sigma(values.size());
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    values[k] = noise.normal() * (k % 6 < 3 ? 3e-3 : 15e-6);
    sigma[k] = k % 6 < 3 ? 0.2e-3 : 1.5e-6;
  }
  content.grid = with_coefficients(content.grid, values);
  content.grid_covariance = sigma.cwiseAbs2().asDiagonal();
  return content;
}

struct Bench {
  TestPiece piece = usual_piece(15, 10);
  KinematicChain chain{trunnion_machine()};
  Model model{.effects = {std::make_shared<RotaryErrorMap>(uncertain_map(), effect_context(trunnion_machine()))}};
};

void envelope(benchmark::State& state) {
  const Bench b;
  const std::vector<ToolPosition> path =
      flank_milling_path(b.piece, b.chain, {.steps_per_turn = kSteps, .largest_turn = Angle::degrees(1)});
  const CutEnvelope cut(actual_tools(path, b.chain, b.model, Length()), solid_of(b.piece.tool), 150);
  const Eigen::Isometry3d frame = w_from_cone(b.piece.cone);
  std::vector<SurfaceRay> rays;
  for (std::size_t j = 0; j < kHeights; ++j)
    for (std::size_t k = 0; k < kAround; ++k) {
      const Angle phi = (static_cast<double>(k) / static_cast<double>(kAround)) * kFullTurn;
      const ConePoint on = cone_point(b.piece.cone, frame, phi,
                                      Length::millimetres(20 * static_cast<double>(j) / static_cast<double>(kHeights)));
      rays.push_back({on.point_w_mm, on.normal_w});
    }
  for (auto _ : state) benchmark::DoNotOptimize(cut.first_entries(rays, 5).data());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(rays.size()));
  state.counters["positions"] = static_cast<double>(path.size());
}
BENCHMARK(envelope)->Name("piece/envelope, a million rays, 100 000 positions")->Unit(benchmark::kSecond)->UseRealTime();

void machine_on_path(benchmark::State& state) {
  const Bench b;
  const std::vector<ToolPosition> path = flank_milling_path(b.piece, b.chain, {.steps_per_turn = kSteps});
  for (auto _ : state) benchmark::DoNotOptimize(actual_tools(path, b.chain, b.model, Length()).data());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(path.size()));
}
BENCHMARK(machine_on_path)->Name("piece/model along the path")->Unit(benchmark::kSecond)->UseRealTime();

void draws(benchmark::State& state) {
  const Bench b;
  const SurfaceGrid surface = evaluated_surface(b.piece);
  const std::vector<ToolPosition> path = flank_milling_path(b.piece, b.chain);
  const DeviationSpread spread(b.piece, surface, path, b.chain, b.model);
  const std::vector<double> deviation =
      envelope_deviation_mm(b.piece, surface, actual_tools(path, b.chain, b.model, Length()));
  for (auto _ : state) benchmark::DoNotOptimize(spread.around(deviation, {.draws = 10000}).heights.data());
  state.SetItemsProcessed(state.iterations() * 10000);
}
BENCHMARK(draws)->Name("piece/10 000 Monte Carlo draws, 3 x 360 points")->Unit(benchmark::kSecond)->UseRealTime();

}  // namespace
}  // namespace trunnion
