#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace trunnion::testing {

/// Random numbers that depend on nothing but the seed: xoshiro256** filled by splitmix64, and normal deviates by Box
/// and Muller, because std::normal_distribution draws differently from library to library.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) {
    for (std::uint64_t& word : state_) {
      seed += 0x9e3779b97f4a7c15U;
      std::uint64_t z = seed;
      z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
      z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
      word = z ^ (z >> 31U);
    }
  }

  std::uint64_t bits() {
    const std::uint64_t drawn = std::rotl(state_[1] * 5, 7) * 9;
    const std::uint64_t shifted = state_[1] << 17U;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= shifted;
    state_[3] = std::rotl(state_[3], 45);
    return drawn;
  }

  /// In [0, 1), on a grid of 2^-53.
  double uniform() { return static_cast<double>(bits() >> 11U) * 0x1p-53; }
  double uniform(double from, double to) { return from + (to - from) * uniform(); }

  /// 0, 1, ..., count - 1, all alike but for one part in 2^64 / count.
  std::uint64_t below(std::uint64_t count) { return bits() % count; }

  /// Mean 0, standard deviation 1.
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));
    const double angle = 2 * std::numbers::pi * uniform();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }

  /// Student's t with `freedom` >= 1 degrees of freedom, not rescaled: its variance is freedom / (freedom - 2).
  double student_t(int freedom) {
    const double numerator = normal();
    double squares = 0;
    for (int i = 0; i < freedom; ++i) {
      const double z = normal();
      squares += z * z;
    }
    return numerator / std::sqrt(squares / freedom);
  }

 private:
  std::uint64_t state_[4] = {};
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace trunnion::testing
