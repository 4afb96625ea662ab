#pragma once

#include <array>
#include <cstdint>

namespace micro {

/// Counter-based random numbers [Salmon11, "Parallel random numbers: as easy as 1, 2, 3", Philox4x32-10]:
/// four independent 32-bit words that depend on (seed, stream, index) alone, so any thread may ask in any
/// order.
std::array<std::uint32_t, 4> random_words(std::uint64_t seed, std::uint32_t stream, std::uint64_t index);

/// Two independent uniform numbers in the open interval (0, 1), 52 bits each.
std::array<double, 2> random_uniform(std::uint64_t seed, std::uint32_t stream, std::uint64_t index);

/// Two independent normal numbers of mean 0 and variance 1 (Box–Muller).
std::array<double, 2> random_normal(std::uint64_t seed, std::uint32_t stream, std::uint64_t index);

}  // namespace micro
