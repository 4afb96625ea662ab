#include "core/random.h"

#include <Random123/philox.h>

#include <cmath>
#include <numbers>

namespace micro {

std::array<std::uint32_t, 4> random_words(std::uint64_t seed, std::uint32_t stream, std::uint64_t index) {
  using Philox = r123::Philox4x32;
  const Philox::ctr_type counter = {
      {static_cast<std::uint32_t>(index), static_cast<std::uint32_t>(index >> 32), stream, 0u}};
  const Philox::key_type key = {{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}};
  const Philox::ctr_type words = Philox()(counter, key);
  return {words[0], words[1], words[2], words[3]};
}

std::array<double, 2> random_uniform(std::uint64_t seed, std::uint32_t stream, std::uint64_t index) {
  const auto w = random_words(seed, stream, index);
  const auto open_unit = [](std::uint32_t high, std::uint32_t low) {
    const std::uint64_t bits =
        (static_cast<std::uint64_t>(high) << 32 | low) >> 12;  // 52 bits, then the midpoint
    return (static_cast<double>(bits) + 0.5) * 0x1p-52;
  };
  return {open_unit(w[0], w[1]), open_unit(w[2], w[3])};
}

std::array<double, 2> random_normal(std::uint64_t seed, std::uint32_t stream, std::uint64_t index) {
  const auto [u, v] = random_uniform(seed, stream, index);
  const double r = std::sqrt(-2 * std::log(u));
  const double phi = 2 * std::numbers::pi * v;
  return {r * std::cos(phi), r * std::sin(phi)};
}

}  // namespace micro
