#include <benchmark/benchmark.h>

#include <string>

#include "identification/as_observations.h"
#include "identification/free_pose_fit.h"
#include "identification/identify.h"
#include "io/observation_file.h"
#include "support/probing_plan.h"
#include "support/smooth_machine.h"

// Readings to maps: 330 touches in process, and a million rows of text.

namespace trunnion {
namespace {

using testing::as_observations;

/// 18 spots; all at the reference pose, thirteen at each of 23 others, and 13 more: 330 touches.
const ObservationSet& touches() {
  static const ObservationSet set = [] {
    testing::Noise noise(1);
    testing::ProbingPlan plan = testing::two_top_plan(13);
    plan.faces = testing::as_built(plan.faces, noise, 20e-3, 50e-6);
    auto rows = probe(testing::smooth_machine(3), plan, {.sigma_mm = 0.175e-3}, noise);
    rows.insert(rows.end(), rows.begin() + 20, rows.begin() + 20 + 330 - static_cast<std::ptrdiff_t>(rows.size()));
    return as_observations(rows);
  }();
  return set;
}

void joint(benchmark::State& state) {
  const LinearProblem problem = make_linear_problem(touches(), testing::plain_machine());
  for (auto _ : state) benchmark::DoNotOptimize(fit_free_poses(problem));
  state.counters["touches"] = static_cast<double>(problem.readings.size());
}
BENCHMARK(joint)->Name("identification/joint fit with covariance, 24 poses")->Unit(benchmark::kMillisecond);

void two_step(benchmark::State& state) {
  const LinearProblem problem = make_linear_problem(touches(), testing::plain_machine());
  for (auto _ : state) benchmark::DoNotOptimize(fit_two_step(problem));
}
BENCHMARK(two_step)->Name("identification/two steps, as the paper")->Unit(benchmark::kMillisecond);

void whole(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(identify(touches(), testing::plain_machine()));
}
BENCHMARK(whole)
    ->Name("identification/outliers, prior by REML, choice of interpolation: the whole of it")
    ->Unit(benchmark::kMillisecond);

void reading(benchmark::State& state) {
  constexpr std::size_t kRows = 1'000'000;
  std::string text = "A_deg,C_deg,point,artifact,x_mm,y_mm,z_mm,nx,ny,nz,repeat,time_s,A_dir,C_dir,temperature_C\n";
  testing::Noise noise(2);
  for (std::size_t i = 0; i < kRows; ++i)
    text += std::to_string(-90 * noise.uniform()) + "," + std::to_string(360 * noise.uniform()) + ",1S" +
            std::to_string(i % 18) + ",1," + std::to_string(100 * noise.normal()) + "," +
            std::to_string(100 * noise.normal()) + "," + std::to_string(100 * noise.normal()) + ",0,0,-1,0," +
            std::to_string(i) + ",-1,1,20.5\n";
  const Machine machine = testing::plain_machine();
  for (auto _ : state) benchmark::DoNotOptimize(parse_observations(text, "log.csv", machine));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kRows));
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(text.size()));
}
BENCHMARK(reading)
    ->Name("reading/an observations file of a million rows and 15 columns")
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace trunnion
