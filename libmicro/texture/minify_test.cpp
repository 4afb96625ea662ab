#include "texture/minify.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/random.h"
#include "distribution/ellipsoid.h"
#include "distribution/scatter.h"

namespace micro {
namespace {

double distance(const SlopeFrame& from, const SlopeFrame& to) {
  const Vec2 t = from.whiten(to.centre);
  return std::max({std::abs(t.x()), std::abs(t.y()), std::abs(to.l11 / from.l11 - 1),
                   std::abs(to.l22 / from.l22 - 1), std::abs(to.l21 - from.l21) / from.l22});
}

/// Lobes whose centres and widths vary as a brushed sample's do, a few widths.
std::vector<SlopeFrame> varied(int n, double spread) {
  std::vector<SlopeFrame> lobes;
  for (int k = 0; k < n; ++k) {
    const auto [a, b] = random_normal(3, 0, static_cast<std::uint64_t>(k));
    const auto [c, d] = random_normal(3, 1, static_cast<std::uint64_t>(k));
    lobes.push_back(slope_frame(
        {0.2 * std::exp(0.3 * c), 0.02 * std::exp(0.3 * d), spread * 0.02 * a, spread * 0.02 * b, 0.1 * d}));
  }
  return lobes;
}

TEST(Minify, LeavesEqualLobesAsTheyAre) {
  constexpr double kTolerance = 1e-3;  // iterations end at steps of 1e-4
  const SlopeFrame needle = slope_frame({0.3, 0.003, 0.4, -0.2, 0.7});
  EXPECT_LE(distance(needle, minified(std::vector<SlopeFrame>(4, needle))), kTolerance);
  EXPECT_LE(misfit(std::vector<SlopeFrame>(4, needle), needle).divergence, 1e-12);
  EXPECT_LE(misfit(std::vector<SlopeFrame>(4, needle), needle).rel_rms, 1e-6);
}

TEST(Minify, FindsTheMostLikelyLobeOfManyDrawnNormals) {
  // Oracle: 200,000 slopes drawn from the mixture and nothing else; they know the frame to 1/√n·2.
  constexpr double kAgree = 0.015;
  for (const double spread : {0., 1., 5.}) {
    const std::vector<SlopeFrame> lobes = varied(64, spread);
    WeightedSlopes drawn;
    for (std::uint64_t k = 0; k < 200000; ++k) {
      const auto [a, b] = random_uniform(5, 0, k);
      const Vec2 slope = lobes[k % lobes.size()].unwhiten(HemisphereShape::sample({a, b}));
      drawn.x.push_back(slope.x());
      drawn.y.push_back(slope.y());
      drawn.weight.push_back(1);
    }
    SlopeFrame oracle = lobes.front();
    for (int k = 0; k < 100; ++k)
      oracle = scatter_step(oracle, drawn, 1e-9);
    EXPECT_LE(distance(oracle, minified(lobes)), kAgree) << spread;
  }
}

/// Density of slopes, from the scale's inverse and determinant.
double t_density(const SlopeFrame& lobe, const Vec2& slope) {
  const Eigen::Matrix2d scale = lobe.scale();
  const Vec2 away = slope - lobe.centre;
  const double q = 1 + away.dot(scale.inverse() * away);
  return 1 / (std::numbers::pi * std::sqrt(scale.determinant()) * q * q);
}

/// ∫ m ln(m/l) − m + l and √(∫(m − l)²/∫m²) by the midpoint rule over rings about `about`.
Misfit slow_misfit(const std::vector<SlopeFrame>& lobes, const SlopeFrame& lobe, const SlopeFrame& about) {
  constexpr int kRings = 150, kAngles = 96;
  Misfit sums;
  double square = 0;
  for (int k = 0; k < kRings; ++k)
    for (int a = 0; a < kAngles; ++a) {
      const double u = (k + 0.5) / kRings, r = std::sqrt(u / (1 - u)),
                   phi = 2 * std::numbers::pi * a / kAngles;
      const Vec2 slope = about.unwhiten({r * std::cos(phi), r * std::sin(phi)});
      const double area = 1 / (kRings * kAngles * t_density(about, slope)), single = t_density(lobe, slope);
      double mixture = 0;
      for (const SlopeFrame& other : lobes)
        mixture += t_density(other, slope) / static_cast<double>(lobes.size());
      sums.divergence += area * (mixture * std::log(mixture / single) - mixture + single);
      sums.rel_rms += area * (mixture - single) * (mixture - single);
      square += area * mixture * mixture;
    }
  return {sums.divergence, std::sqrt(sums.rel_rms / square)};
}

TEST(Minify, MisfitIsTheIntegralOverSlopes) {
  constexpr double kOfItself = 0.1;  // as its header says
  for (const int n : {2, 16, 64, 300})
    for (const double spread : {0.3, 2.}) {
      const std::vector<SlopeFrame> lobes = varied(n, spread);
      for (const SlopeFrame& lobe : {minified(lobes), lobes.front()}) {
        const Misfit quick = misfit(lobes, lobe), slow = slow_misfit(lobes, lobe, minified(lobes));
        EXPECT_NEAR(quick.divergence, slow.divergence, kOfItself * slow.divergence) << n << " " << spread;
        EXPECT_NEAR(quick.rel_rms, slow.rel_rms, kOfItself * slow.rel_rms) << n << " " << spread;
      }
    }
}

TEST(Minify, IsBetterThanAnyNeighbourAndThanAveraging) {
  // Nothing two hundredths of a width away is better: the best is less than one away. (Four lobes, widths
  // apart, stand as 72 slopes: twice that.)
  for (const auto& [n, length] : {std::pair(4, 0.04), std::pair(16, 0.02), std::pair(64, 0.02)}) {
    const std::vector<SlopeFrame> lobes = varied(n, 3);
    const SlopeFrame best = minified(lobes);
    const double least = slow_misfit(lobes, best, best).divergence;
    for (int k = 0; k < 5; ++k)
      for (const double step : {-length, length}) {
        SlopeFrame other = best;
        if (k == 0) other.centre = best.unwhiten({step, 0});
        if (k == 1) other.centre = best.unwhiten({0, step});
        if (k == 2) other.l11 *= 1 + step;
        if (k == 3) other.l21 += step * other.l22;
        if (k == 4) other.l22 *= 1 + step;
        EXPECT_GT(slow_misfit(lobes, other, best).divergence, least) << n << " " << k << " " << step;
      }
  }
  const std::vector<SlopeFrame> lobes = varied(16, 3);
  const SlopeFrame best = minified(lobes);
  const double least = misfit(lobes, best).divergence;
  // Averaged widths know nothing of centres that differ: the lobe comes out too narrow by far.
  const SlopeFrame naive = naive_average(lobes);
  EXPECT_GT(misfit(lobes, naive).divergence, 5 * least);
  EXPECT_LT(naive.l11 * naive.l22, 0.6 * best.l11 * best.l22);
}

TEST(Minify, AveragingWrapsWhereSlopeSpaceDoesNot) {
  // Two nearly equal lobes on either side of θ_z = π/2 average to one turned by a right angle.
  const std::vector<SlopeFrame> lobes = {slope_frame({0.2, 0.05, 0, 0, std::numbers::pi / 2 - 0.02}),
                                         slope_frame({0.2, 0.05, 0, 0, std::numbers::pi / 2 + 0.02})};
  EXPECT_LE(misfit(lobes, minified(lobes)).divergence, 0.02);
  EXPECT_GT(misfit(lobes, naive_average(lobes)).divergence, 0.3);
}

TEST(Minify, BordersCountByWhatTheyCover) {
  // 4 × 4 texels of one lobe, then a row and a column of another, by way of level 1: 16 and 9 parts.
  TextureField field;
  for (std::size_t c = 0; c < kChannels; ++c) {
    field[c] = Grid<float>::Constant(5, 5, c < 2 ? 0.F : -2.F);
    field[c].row(4).setConstant(c < 2 ? 0.3F : -0.5F);
    field[c].col(4).setConstant(c < 2 ? 0.3F : -0.5F);
  }
  constexpr float kTolerance = 0.01F;  // as few points are good for
  const TextureField once = minified(field, 3), twice = minified(minified(field, 1), 2, {5, 5}, 1);
  for (std::size_t c = 0; c < kChannels; ++c)
    EXPECT_NEAR(once[c](0, 0), twice[c](0, 0), kTolerance) << c;
}

TEST(Minify, TakesGapsOddSizesAndExtremes) {
  TextureField field;
  for (auto& channel : field)
    channel = Grid<float>::Random(5, 7);
  field[0](0, 0) = std::nanf("");
  const TextureField coarse = minified(field, 1), top = minified(field, 3);
  EXPECT_EQ(coarse[0].rows(), 3);
  EXPECT_EQ(coarse[0].cols(), 4);
  EXPECT_EQ(top[0].size(), 1);
  for (const auto& channel : coarse)
    EXPECT_TRUE(channel.isFinite().all());
  // The last texel covers one alone.
  EXPECT_NEAR(coarse[2](2, 3), field[2](4, 6), 2e-3);
  EXPECT_EQ(level_count({5, 7}), 4);
  EXPECT_EQ(level_count({1, 1}), 1);
  const std::vector<SlopeFrame> far = {slope_frame({1e-6, 1e-6, 0, 0, 0}),
                                       slope_frame({1e-6, 1e-6, 0.5, 0, 0}), slope_frame({1, 1e-5, 0, 0, 0})};
  const SlopeFrame frame = minified(far);
  EXPECT_TRUE(std::isfinite(frame.l11) && frame.l11 > 0 && std::isfinite(frame.l22) && frame.l22 > 0);
  const SlopeFrame gap = {{NAN, NAN}, NAN, NAN, NAN};
  EXPECT_TRUE(std::isnan(minified(std::vector<SlopeFrame>(2, gap)).l11));
}

}  // namespace
}  // namespace micro
