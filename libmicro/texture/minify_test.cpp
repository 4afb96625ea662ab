#include "texture/minify.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

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
  EXPECT_LE(misfit(std::vector<SlopeFrame>(4, needle), needle).divergence, 1e-6);
  EXPECT_LE(misfit(std::vector<SlopeFrame>(4, needle), needle).rel_rms, 0.05);  // by the midpoint rule
}

TEST(Minify, FindsTheMostLikelyLobeOfManyDrawnNormals) {
  // Oracle: 200,000 slopes drawn from the mixture and nothing else; they know the frame to 1/√n·2, twelve
  // points a lobe to about a percent.
  constexpr double kAgree = 0.03;
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

TEST(Minify, IsBetterThanAnyNeighbourAndThanAveraging) {
  const std::vector<SlopeFrame> lobes = varied(16, 3);
  const SlopeFrame best = minified(lobes);
  const double least = misfit(lobes, best).divergence;
  EXPECT_GT(least, 0);
  for (int k = 0; k < 5; ++k)
    for (const double step : {-0.15, 0.15}) {
      SlopeFrame other = best;
      if (k == 0) other.centre = best.unwhiten({step, 0});
      if (k == 1) other.centre = best.unwhiten({0, step});
      if (k == 2) other.l11 *= 1 + step;
      if (k == 3) other.l21 += step * other.l22;
      if (k == 4) other.l22 *= 1 + step;
      EXPECT_GT(misfit(lobes, other).divergence, least) << k << " " << step;
    }
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
