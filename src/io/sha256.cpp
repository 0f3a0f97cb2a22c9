#include "io/sha256.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace trunnion {
namespace {

/// The first 32 bits of the fraction of the n-th root of a prime: the standard's constants, exactly.
std::uint32_t root_fraction(std::uint32_t prime, int root) {
  // floor(prime^(1/root) 2^32) by bisection in whole numbers.
  __extension__ typedef unsigned __int128 Wide;
  std::uint64_t low = 0, high = std::uint64_t{1} << 40;
  while (high - low > 1) {
    const std::uint64_t middle = low + (high - low) / 2;
    bool below;
    if (root == 2) {
      below = Wide(middle) * middle <= (Wide(prime) << 64);
    } else {
      const Wide square = Wide(middle) * middle;  // middle^3 <= prime 2^96, compared without overflow
      below = square <= (Wide(prime) << 96) / middle;
    }
    (below ? low : high) = middle;
  }
  return static_cast<std::uint32_t>(low);
}

struct Constants {
  std::array<std::uint32_t, 8> start{};
  std::array<std::uint32_t, 64> round{};
};

const Constants& constants() {
  static const Constants value = [] {
    Constants c;
    std::size_t found = 0;
    for (std::uint32_t n = 2; found < 64; ++n) {
      bool prime = true;
      for (std::uint32_t d = 2; d * d <= n; ++d) prime = prime && n % d != 0;
      if (!prime) continue;
      if (found < 8) c.start[found] = root_fraction(n, 2);
      c.round[found++] = root_fraction(n, 3);
    }
    return c;
  }();
  return value;
}

void compress(std::array<std::uint32_t, 8>& state, const unsigned char* block) {
  const Constants& k = constants();
  std::array<std::uint32_t, 64> w{};
  for (std::size_t i = 0; i < 16; ++i)
    w[i] = std::uint32_t{block[4 * i]} << 24 | std::uint32_t{block[4 * i + 1]} << 16 |
           std::uint32_t{block[4 * i + 2]} << 8 | block[4 * i + 3];
  for (std::size_t i = 16; i < 64; ++i) {
    const std::uint32_t s0 = std::rotr(w[i - 15], 7) ^ std::rotr(w[i - 15], 18) ^ (w[i - 15] >> 3);
    const std::uint32_t s1 = std::rotr(w[i - 2], 17) ^ std::rotr(w[i - 2], 19) ^ (w[i - 2] >> 10);
    w[i] = w[i - 16] + s0 + w[i - 7] + s1;
  }
  auto [a, b, c, d, e, f, g, h] = state;
  for (std::size_t i = 0; i < 64; ++i) {
    const std::uint32_t s1 = std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25);
    const std::uint32_t t1 = h + s1 + ((e & f) ^ (~e & g)) + k.round[i] + w[i];
    const std::uint32_t s0 = std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22);
    const std::uint32_t t2 = s0 + ((a & b) ^ (a & c) ^ (b & c));
    h = g, g = f, f = e, e = d + t1, d = c, c = b, b = a, a = t1 + t2;
  }
  const std::array<std::uint32_t, 8> add = {a, b, c, d, e, f, g, h};
  for (std::size_t i = 0; i < 8; ++i) state[i] += add[i];
}

}  // namespace

std::string sha256_hex(std::string_view bytes) {
  std::array<std::uint32_t, 8> state = constants().start;
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  std::size_t at = 0;
  for (; at + 64 <= bytes.size(); at += 64) compress(state, data + at);
  std::array<unsigned char, 128> tail{};
  const std::size_t rest = bytes.size() - at;
  for (std::size_t i = 0; i < rest; ++i) tail[i] = data[at + i];
  tail[rest] = 0x80;
  const std::size_t length = rest < 56 ? 64 : 128;
  const std::uint64_t bits = std::uint64_t{bytes.size()} * 8;
  for (std::size_t i = 0; i < 8; ++i) tail[length - 1 - i] = static_cast<unsigned char>(bits >> (8 * i));
  for (std::size_t i = 0; i < length; i += 64) compress(state, tail.data() + i);
  std::string hex;
  for (const std::uint32_t word : state)
    for (int shift = 28; shift >= 0; shift -= 4) hex += "0123456789abcdef"[word >> shift & 15U];
  return hex;
}

}  // namespace trunnion
