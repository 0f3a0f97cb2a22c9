#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <cstring>

#include "errormap/fields.h"
#include "model/effects/rotary_error_map.h"
#include "postproc/block.h"
#include "postproc/chunk_writer.h"
#include "postproc/dialect.h"
#include "postproc/model_field.h"

// The three parts of correcting a program, each on one core and in memory, beside a plain copy of the same text.

namespace trunnion {
namespace {

constexpr int kLines = 4000;  // what one chunk holds

/// Lines of five words as a CAM system posts them.
std::string regular_lines() {
  std::string text = "G21 G90 G94 G17\nG0 X50. Y0. Z40. A-45. C0.\nG1 F3000.\n";
  char line[120];
  for (int i = 0; i < kLines; ++i) {
    const double t = 0.002 * i;
    std::snprintf(line, sizeof line, "N%d G1 X%.4f Y%.4f Z%.4f A%.4f C%.4f\n", i + 1, 50 * std::cos(t),
                  50 * std::sin(t), 40 + 5 * std::sin(3 * t), -45 - 30 * std::sin(0.3 * t), 57.29578 * t);
    text += line;
  }
  return text;
}

/// A program of the seed machine, its model baked, and what scanning and solving it give.
struct Work {
  Machine machine = twin("w C' A' Y' b X Z t").machine;
  KinematicChain chain{machine};
  Model model{.effects = {std::make_shared<RotaryErrorMap>(
                  RotaryMapContent{.grid = sampled(band_limited, stations_deg({-90, -60, -30, 0}),
                                                   stations_deg({0, 60, 120, 180, 240, 300}))},
                  effect_context(machine))}};
  ModelField field{model, {}, {Angle::degrees(-90), Angle::degrees(0)}};
  bool baked = field.bake(chain);
  Corrector with_tcp{chain, field, {}}, without_tcp{chain, field, {.tcp = ToolCentrePoint::off}};
  ScanSettings settings;
  CorrectionGuard guard;
  std::string text = regular_lines();
  ScannedChunk scanned;

  Work() {
    settings.chain = &chain;
    scan(scanned);
  }

  void scan(ScannedChunk& chunk) const {
    const auto scanner = dialect("linuxcnc").scanner(settings);
    chunk.blocks.clear();
    const std::string_view all = text;
    for (std::size_t at = 0; at < all.size();) {
      const std::size_t length = line_length(all.substr(at));
      scanner->scan(all.substr(at, length), static_cast<std::uint32_t>(at), chunk);
      at += length;
    }
  }

  void tell(benchmark::State& state) const {
    state.SetItemsProcessed(state.iterations() * kLines);
    state.counters["MB_per_s"] = benchmark::Counter(
        1e-6 * static_cast<double>(text.size()) * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
  }
};

const Work& work() {
  static const Work one;
  return one;
}

void copy(benchmark::State& state) {
  std::string out(work().text.size(), '\0');
  for (auto _ : state) {
    std::memcpy(out.data(), work().text.data(), out.size());
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
  }
  work().tell(state);
}
BENCHMARK(copy)->Name("program parts/a plain copy")->Unit(benchmark::kMicrosecond);

void read(benchmark::State& state) {
  ScannedChunk chunk;
  for (auto _ : state) {
    work().scan(chunk);
    benchmark::DoNotOptimize(chunk.blocks.data());
  }
  work().tell(state);
}
BENCHMARK(read)->Name("program parts/reading")->Unit(benchmark::kMicrosecond);

void correct(benchmark::State& state) {
  const PathSolver solver(work().with_tcp, work().without_tcp, work().guard, work().settings.letters);
  Solution solution;
  for (auto _ : state)
    for (const MotionBlock& block : work().scanned.blocks) {
      solver.solve(block, block.target, solution);
      benchmark::DoNotOptimize(solution);
    }
  work().tell(state);
}
BENCHMARK(correct)->Name("program parts/correcting")->Unit(benchmark::kMicrosecond);

void write(benchmark::State& state) {
  const PathSolver solver(work().with_tcp, work().without_tcp, work().guard, work().settings.letters);
  std::vector<Ticks> ticks;
  for (const MotionBlock& block : work().scanned.blocks) ticks.push_back(solver.solved(block, block.target).ticks);
  BlockText text(work().settings.letters, {});
  for (auto _ : state) {
    text.begin(work().text);
    for (std::size_t i = 1; i < ticks.size(); ++i)
      text.rewrite_plainly(work().scanned.blocks[i], ticks[i], ticks[i - 1]);
    benchmark::DoNotOptimize(text.finish().text.data());
  }
  work().tell(state);
}
BENCHMARK(write)->Name("program parts/writing")->Unit(benchmark::kMicrosecond);

void whole(benchmark::State& state) {
  ChunkWriter writer(work().with_tcp, work().without_tcp, work().guard, work().settings.letters, {}, false);
  ScannedChunk chunk;
  for (auto _ : state) {
    work().scan(chunk);
    benchmark::DoNotOptimize(writer.write(work().text, chunk).text.data());
  }
  work().tell(state);
}
BENCHMARK(whole)->Name("program parts/all three, one core")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace trunnion
