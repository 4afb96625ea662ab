#include "core/random.h"

#include <gtest/gtest.h>

#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>

namespace micro {
namespace {

/// One test in a million fails by chance.
constexpr double kSignificance = 1e-6;

// Known-answer test published with Random123: counter 0, key 0.
TEST(Random, IsPhilox) {
  const auto w = random_words(0, 0, 0);
  EXPECT_EQ(w[0], 0x6627e8d5u);
  EXPECT_EQ(w[1], 0xe169c58du);
  EXPECT_EQ(w[2], 0xbc57ac4cu);
  EXPECT_EQ(w[3], 0x9b00dbd8u);
}

TEST(Random, UniformFillsItsBinsEvenly) {
  constexpr int kBins = 64, kPairs = 100000;
  std::array<int, kBins * kBins> counts{};
  for (int i = 0; i < kPairs; ++i) {
    const auto [u, v] = random_uniform(7, 3, static_cast<std::uint64_t>(i));
    ASSERT_TRUE(u > 0 && u < 1 && v > 0 && v < 1);
    ++counts[static_cast<std::size_t>(static_cast<int>(u * kBins) * kBins + static_cast<int>(v * kBins))];
  }
  const double expected = static_cast<double>(kPairs) / (kBins * kBins);
  double chi2 = 0;
  for (const int count : counts)
    chi2 += (count - expected) * (count - expected) / expected;
  const boost::math::chi_squared distribution(kBins * kBins - 1);
  EXPECT_GT(cdf(complement(distribution, chi2)), kSignificance);
  EXPECT_GT(cdf(distribution, chi2), kSignificance);
}

TEST(Random, NormalHasItsMoments) {
  constexpr int kPairs = 200000;
  double m1 = 0, m2 = 0, m4 = 0, cross = 0;
  for (int i = 0; i < kPairs; ++i) {
    const auto [a, b] = random_normal(11, 0, static_cast<std::uint64_t>(i));
    m1 += a + b;
    m2 += a * a + b * b;
    m4 += a * a * a * a + b * b * b * b;
    cross += a * b;
  }
  // z values: var(x) = 1, var(x²) = 2, var(x⁴) = 96, var(ab) = 1.
  const double n = 2 * kPairs;
  constexpr double kZ = 5;  // 6e-7 two-sided, four tests
  EXPECT_LT(std::abs(m1 / std::sqrt(n)), kZ);
  EXPECT_LT(std::abs((m2 - n) / std::sqrt(2 * n)), kZ);
  EXPECT_LT(std::abs((m4 - 3 * n) / std::sqrt(96 * n)), kZ);
  EXPECT_LT(std::abs(cross / std::sqrt(static_cast<double>(kPairs))), kZ);
}

}  // namespace
}  // namespace micro
