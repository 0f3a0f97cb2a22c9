#include <benchmark/benchmark.h>

#include "discovery/closure_case.h"
#include "identification/as_observations.h"

// The whole search for missing effects, 657 touches of three passes: where something is missing, and where nothing is.

namespace trunnion {
namespace {

void close(benchmark::State& state, std::vector<std::string> effects) {
  const testing::ClosureOutcome once = testing::close_case(
      {.seed = 1, .effects = std::move(effects), .measured = testing::Measured::three_passes, .noncentrality = 100});
  const ObservationSet& set = *once.closure.problem.observations;
  for (auto _ : state) benchmark::DoNotOptimize(close_loop(set, set.rows.size(), testing::plain_machine()));
  state.counters["columns scanned"] = static_cast<double>(once.closure.columns_scanned);
  state.counters["effects found"] = static_cast<double>(once.closure.effects.size());
}
BENCHMARK_CAPTURE(close, none, {})->Name("closure/657 touches, nothing missing")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(close, one, {"backlash:C"})->Name("closure/657 touches, a backlash")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(close, two, {"thermal_drift", "squareness:XZ"})
    ->Name("closure/657 touches, a drift and a squareness")
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace trunnion
