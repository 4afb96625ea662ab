#include "pipelines/shadowing_simulation.h"

#include <gtest/gtest.h>

#include <array>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <numbers>
#include <numeric>

#include "brdf/free_travel.h"
#include "core/error.h"
#include "core/parallel.h"

namespace micro {
namespace {

/// |z| of a sound estimate exceeds this once in 15,000 times.
constexpr double kMostZ = 4;

double gaussian(double x) {
  return cdf(boost::math::normal(), x);
}

TEST(ShadowingSimulation, RaysEscapeAsTheLiteralSearchSays) {
  const std::vector<double> h = gaussian_profile(400, 8, 3);
  for (const double rise : {0.02, 0.1, 0.4}) {
    const std::vector<char> escapes = escapes_to_the_right(h, rise);
    for (std::size_t k = 0; k < h.size(); ++k) {
      bool blocked = false;
      for (std::size_t j = k + 1; j < h.size(); ++j)
        blocked = blocked || h[j] > h[k] + rise * static_cast<double>(j - k);
      EXPECT_EQ(escapes[k] == 0, blocked) << k << ' ' << rise;
    }
  }
}

TEST(ShadowingSimulation, ProfilesHaveTheirStatistics) {
  // Variance, correlation at τ/2, variance of steps, and how often neighbours lie on both sides of the mean
  // height, arccos(C)/π; each held against its spread over profiles.
  constexpr int kPerTau = 16, kLength = 512, kProfiles = 64;
  const double step2 = 2 * (1 - std::exp(-1. / (kPerTau * kPerTau)));
  const double expected[] = {1, std::exp(-0.25), step2,
                             std::acos(std::exp(-1. / (kPerTau * kPerTau))) / std::numbers::pi};
  double sum[4] = {}, square[4] = {};
  for (int i = 0; i < kProfiles; ++i) {
    const std::vector<double> h =
        gaussian_profile(kLength * kPerTau + kPerTau, kPerTau, static_cast<std::uint64_t>(i));
    double mean[4] = {};
    for (std::size_t k = 0; k < kLength * kPerTau; ++k) {
      const double d = h[k + 1] - h[k];
      const double values[] = {h[k] * h[k], h[k] * h[k + kPerTau / 2], d * d,
                               (h[k] < 0) != (h[k + 1] < 0) ? 1. : 0.};
      for (int q = 0; q < 4; ++q)
        mean[q] += values[q] / (kLength * kPerTau);
    }
    for (int q = 0; q < 4; ++q) {
      sum[q] += mean[q] / kProfiles;
      square[q] += mean[q] * mean[q] / kProfiles;
    }
  }
  for (int q = 0; q < 4; ++q) {
    const double error = std::sqrt((square[q] - sum[q] * sum[q]) / (kProfiles - 1));
    EXPECT_LE(std::abs(sum[q] - expected[q]) / error, kMostZ) << q << ' ' << sum[q] << ' ' << expected[q];
  }
}

/// ∫Q dt is the mean length of the surface above a ray that starts at height η: counted on profiles, in a bin
/// of η, it must be the quadrature of [Sun02 Eqs. 3.4.7–3.4.14].
TEST(ShadowingSimulation, CoveredLengthIsSunsQuadrature) {
  constexpr int kPerTau = 16, kProfiles = 300, kReach = 20, kLength = 256, kCases = 6;
  constexpr double kHalfBin = 0.05;
  const struct {
    double nu, eta;
  } cases[kCases] = {{0.5, -1}, {0.5, 0}, {0.5, 1}, {1.5, -1}, {1.5, 0}, {1.5, 1}};
  std::array<std::vector<double>, kCases> covered, starts;
  for (int i = 0; i < kProfiles; ++i) {
    const std::vector<double> h =
        gaussian_profile((kLength + kReach) * kPerTau, kPerTau, 1000 + static_cast<std::uint64_t>(i));
    for (std::size_t c = 0; c < kCases; ++c) {
      const auto [nu, eta] = cases[c];
      double length = 0, count = 0;
      for (std::size_t k = 0; k < kLength * kPerTau; k += kPerTau / 4) {
        if (std::abs(h[k] - eta) > kHalfBin) continue;
        count += 1;
        for (std::size_t j = 1; j <= kReach * kPerTau; ++j)
          length += h[k + j] > h[k] + nu * static_cast<double>(j) / kPerTau ? 1. / kPerTau : 0.;
      }
      covered[c].push_back(length);
      starts[c].push_back(count);
    }
  }
  for (std::size_t c = 0; c < kCases; ++c) {
    const auto [nu, eta] = cases[c];
    const double all = std::accumulate(starts[c].begin(), starts[c].end(), 0.);
    const double mean = std::accumulate(covered[c].begin(), covered[c].end(), 0.) / all;
    double square = 0;
    for (std::size_t i = 0; i < kProfiles; ++i)
      square += std::pow(covered[c][i] - mean * starts[c][i], 2);
    // Points j ≥ 1 are the trapezoidal rule without half of its first one, Q(0) = P(slope > ray).
    const double first = gaussian(-nu / std::sqrt(2.)) / (2 * kPerTau);
    const double z = (mean + first - mean_covered_length(eta, nu, 1e-9).value) * all / std::sqrt(square);
    EXPECT_LE(std::abs(z), kMostZ) << "nu " << nu << " eta " << eta << ": " << mean + first;
  }
}

TEST(ShadowingSimulation, FacingFractionAndErrorsAreThose) {
  const ShadowingRequest request{{0.5, 2, 6}, 64, 512, 32, 7};
  const std::vector<ShadowingRow> rows = simulate_shadowing(request);
  ASSERT_EQ(rows.size(), 3u);
  for (const ShadowingRow& row : rows) {
    // Steps of a profile have variance 2(1 − C) a little below that of slopes.
    const double step = std::sqrt(-2 * std::expm1(-1. / (32. * 32.))) * 32;
    const double facing = static_cast<double>(row.from_anywhere.facing.cost.evaluations) /
                          static_cast<double>(row.from_anywhere.all.cost.evaluations);
    EXPECT_NEAR(facing, gaussian(row.nu / step), 0.003);
    // Who starts into the surface does not escape.
    EXPECT_NEAR(row.from_anywhere.all.value, facing * row.from_anywhere.facing.value, 1e-12);
    EXPECT_LE(row.both_ways.all.value, row.from_anywhere.all.value);
    EXPECT_EQ(row.rays, 2 * 64 * 512 * 32);
  }
  EXPECT_GT(rows[0].from_anywhere.all.error, 0);
}

TEST(ShadowingSimulation, EqualForAnyNumberOfThreads) {
  const ShadowingRequest request{{1}, 4, 64, 16, 7};
  set_thread_count(1);
  const ShadowingRow one = simulate_shadowing(request).front();
  set_thread_count(0);
  const ShadowingRow many = simulate_shadowing(request).front();
  EXPECT_EQ(one.from_anywhere.all.value, many.from_anywhere.all.value);
  EXPECT_EQ(one.from_mean_height().all.error, many.from_mean_height().all.error);
}

TEST(ShadowingSimulation, RefusesTheHorizon) {
  EXPECT_THROW(simulate_shadowing({{0.}, 4, 64, 16, 7}), InputError);
  EXPECT_THROW(simulate_shadowing({{1.}, 1, 64, 16, 7}), InputError);
}

}  // namespace
}  // namespace micro
