#include <benchmark/benchmark.h>

#include <cmath>

#include "errormap/baked_map.h"
#include "errormap/fields.h"
#include "support/noise.h"

// Deviations at positions drawn over the whole range, in no order: the worst that a program can ask for.

namespace trunnion {
namespace {

constexpr std::size_t kPositions = 1 << 16;

struct Table {
  KinematicChain chain{twin("w C' A' Y' b X Z t").machine};
  std::shared_ptr<const ErrorSurface> surface;
  RotaryErrors reference = surface->at({});
  PoseError operator()(IndexedPosition at) const {
    return relative_pose_error(chain, at, surface->at(at), reference, {});
  }
};

Table table(Interpolation method) {
  const auto grid = sampled(band_limited, stations_deg({-90, -60, -30, 0}), stations_deg({0, 60, 120, 180, 240, 300}));
  return {.surface = make_surface(method, grid)};
}

struct Positions {
  std::vector<double> a, c;
  std::vector<Eigen::Vector3d> p, d = std::vector<Eigen::Vector3d>(kPositions);
  Positions() {
    testing::Noise noise(1);
    for (std::size_t k = 0; k < kPositions; ++k) {
      a.push_back(noise.uniform(Angle::degrees(-90).in_radians(), 0)), c.push_back(noise.uniform(-6, 6));
      p.push_back(150 * Eigen::Vector3d(noise.uniform(-1, 1), noise.uniform(-1, 1), noise.uniform(-1, 1)));
    }
  }
};

const Range<Angle> kRange{Angle::degrees(-90), Angle::degrees(0)};

void baked(benchmark::State& state) {
  const BakedMap map(table(Interpolation::trig_cubic), kRange);
  Positions at;
  for (auto _ : state) {
    map.deviations_mm(at.a, at.c, at.p, at.d);
    benchmark::DoNotOptimize(at.d.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kPositions));
  state.counters["error_um"] = map.error().displacement.in_micrometres();
  state.counters["error_urad"] = map.error().rotation.in_microradians();
  state.counters["grid_A"] = static_cast<double>(map.a_nodes());
  state.counters["grid_C"] = static_cast<double>(map.c_nodes());
}
BENCHMARK(baked)->Name("deviations/baked map")->Unit(benchmark::kMillisecond);

void baked_slopes(benchmark::State& state) {
  const BakedMap map(table(Interpolation::trig_cubic), kRange);
  const Positions at;
  for (auto _ : state)
    for (std::size_t k = 0; k < kPositions; ++k)
      benchmark::DoNotOptimize(map.with_slopes({Angle::radians(at.a[k]), Angle::radians(at.c[k])}));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kPositions));
}
BENCHMARK(baked_slopes)->Name("deviations/baked map, one at a time with slopes")->Unit(benchmark::kMillisecond);

void surface(benchmark::State& state, Interpolation method) {
  const Table original = table(method);
  Positions at;
  constexpr std::size_t kFew = 4096;
  for (auto _ : state)
    for (std::size_t k = 0; k < kFew; ++k) {
      at.d[k] = displacement_mm(original({Angle::radians(at.a[k]), Angle::radians(at.c[k])}), at.p[k]);
      benchmark::DoNotOptimize(at.d[k]);
    }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kFew));
}
BENCHMARK_CAPTURE(surface, trig_cubic, Interpolation::trig_cubic)
    ->Name("deviations/trigonometric x cubic, not baked")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(surface, bilinear, Interpolation::bilinear)
    ->Name("deviations/bilinear, not baked")
    ->Unit(benchmark::kMillisecond);

void bake(benchmark::State& state) {
  const Table original = table(Interpolation::trig_cubic);
  for (auto _ : state) benchmark::DoNotOptimize(BakedMap(original, kRange));
}
BENCHMARK(bake)->Name("baking/trigonometric x cubic to 1 nm")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace trunnion
