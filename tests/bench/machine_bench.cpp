#include <benchmark/benchmark.h>

#include <cstring>
#include <vector>

// What the machine itself can do: copying memory that no cache holds, the measure for everything else.

namespace {

void copy_memory(benchmark::State& state) {
  const std::vector<char> from(std::size_t{1} << 28, 1);
  std::vector<char> to(from.size());
  for (auto _ : state) {
    std::memcpy(to.data(), from.data(), from.size());
    benchmark::DoNotOptimize(to.data());
    benchmark::ClobberMemory();
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(from.size()));
}
BENCHMARK(copy_memory)->Name("machine/copy of 256 MB")->Unit(benchmark::kMillisecond);

}  // namespace
