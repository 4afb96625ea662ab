#pragma once

#include <cstdint>
#include <vector>

#include "core/estimate.h"

namespace micro {

/// Part of the rays that escape: of all those that start somewhere, and of those that start on a facet that
/// faces them. The others start into the surface.
struct EscapingPart {
  Estimate<double> all, facing;
};

/// Bins of η = h/σ_h, each 0.1 wide.
struct HeightBins {
  static constexpr int kCount = 63;
  static constexpr double kWidth = 0.1;
  static constexpr int kMean = kCount / 2;
  static double centre(int bin) { return (bin - kMean) * kWidth; }
};

/// What the rays of slope ν = s·cot θ (steps of σ_h a step of τ) do.
struct ShadowingRow {
  double nu = 0;
  std::int64_t rays = 0;                  ///< towards +x and towards −x
  std::vector<EscapingPart> from_height;  ///< for each of HeightBins
  Estimate<double> from_crossings;  ///< of all that start where a profile crosses its mean height: steep
                                    ///< places are crossed more often
  const EscapingPart& from_mean_height() const { return from_height[HeightBins::kMean]; }
  EscapingPart from_anywhere;
  EscapingPart both_ways;            ///< starts whose rays towards +x and −x both escape
  Estimate<double> level_both_ways;  ///< the same of facets whose slope is below 0.1 σ_h/τ: the mirror's
};

struct ShadowingRequest {
  std::vector<double> nu;
  int profiles = 512;
  int length = 4096;        ///< of a profile, in τ, besides what rays need to rise out of the heights
  int points_per_tau = 32;  ///< of the profile, straight in between
  std::uint64_t seed = 1;
};

/// Simulates rays over profiles of Gaussian surfaces made by a moving average [Sun02 §4, Figs. 6, 7]. A ray
/// that leaves x₀ to the right escapes if no later point has a larger h(x) − νx, so that one pass from the
/// right answers for every point of a profile at once: all of them start rays. Standard errors are over
/// profiles, which are independent. Throws InputError unless every ν is positive.
std::vector<ShadowingRow> simulate_shadowing(const ShadowingRequest& request);

/// One profile as the simulation uses it, h/σ_h at `points_per_tau` points each τ.
std::vector<double> gaussian_profile(std::int64_t points, int points_per_tau, std::uint64_t seed);

/// For each point of a profile whether the ray from it to the right, rising by `rise` from point to point,
/// escapes it.
std::vector<char> escapes_to_the_right(const std::vector<double>& profile, double rise);

}  // namespace micro
