#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace trunnion {

/// Calls `work(first, last)` for consecutive blocks of 0 … count-1 on `threads` threads (0: as many as there are
/// processors), and waits. The first exception thrown is thrown again here. Results must not depend on the division.
template <class Work>
void in_blocks(std::size_t count, unsigned threads, Work work) {
  const std::size_t most = threads > 0 ? threads : std::max(1U, std::thread::hardware_concurrency());
  const std::size_t blocks = std::clamp<std::size_t>(count, 1, most);
  if (blocks == 1) return work(std::size_t{0}, count);
  std::exception_ptr failure;
  std::mutex guard;
  {
    std::vector<std::jthread> pool;
    for (std::size_t b = 0; b < blocks; ++b)
      pool.emplace_back([&, b] {
        try {
          work(count * b / blocks, count * (b + 1) / blocks);
        } catch (...) {
          const std::scoped_lock lock(guard);
          if (!failure) failure = std::current_exception();
        }
      });
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace trunnion
