#include "texture/synthesis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"
#include "texture/marginals.h"

namespace micro {
namespace {

/// Sums of float32 fields.
constexpr double kFloat = 1e-4;

std::array<double, 5> normals(std::uint64_t seed, std::uint64_t k) {
  const auto a = random_normal(seed, 0, k), b = random_normal(seed, 1, k), c = random_normal(seed, 2, k);
  return {a[0], a[1], b[0], b[1], c[0]};
}

/// Correlated noise, smoothed along both axes: channel 1 is minus channel 0, a texel later.
Exemplar block(Eigen::Index rows, Eigen::Index cols, std::uint64_t seed = 1) {
  Exemplar exemplar = make_exemplar(rows, cols);
  for (auto& channel : exemplar.channels)
    channel.setZero();
  for (Eigen::Index j = 0; j < rows; ++j)
    for (Eigen::Index i = 0; i < cols; ++i)
      for (Eigen::Index dj = -2; dj <= 2; ++dj)
        for (Eigen::Index di = -4; di <= 4; ++di) {
          const auto at = [&](Eigen::Index shift) {
            return normals(seed, static_cast<std::uint64_t>((j + dj + 50) * 100000 + i + di + shift + 50));
          };
          const double weight =
              std::exp(-0.5 * static_cast<double>(dj * dj) - 0.1 * static_cast<double>(di * di));
          const auto here = at(0), later = at(-1);
          exemplar.channels[0](j, i) += 0.01 * weight * here[0];
          exemplar.channels[1](j, i) -= 0.02 * weight * later[0];
          for (std::size_t c = 2; c < 5; ++c)
            exemplar.channels[c](j, i) += 0.1 * weight * (here[c] + 0.5 * here[0]);
        }
  for (std::size_t c = 0; c < 5; ++c)
    exemplar.channels[c] += static_cast<double>(c) - 2;
  return exemplar;
}

Exemplar as_exemplar(const TextureField& field) {
  Exemplar exemplar;
  for (std::size_t c = 0; c < kChannels; ++c)
    exemplar.channels[c] = field[c].cast<double>();
  return exemplar;
}

/// ⟨a(x)·b(x + lag)⟩ of deviations, periodic or not, over √ of both variances.
double correlation(const Exemplar& e, std::size_t a, std::size_t b, Eigen::Index dj, Eigen::Index di,
                   bool periodic) {
  const ExemplarMoments m = moments_of(e);
  double sum = 0;
  std::int64_t count = 0;
  for (Eigen::Index j = 0; j < e.rows(); ++j)
    for (Eigen::Index i = 0; i < e.cols(); ++i) {
      Eigen::Index jj = j + dj, ii = i + di;
      if (!periodic && (jj >= e.rows() || ii >= e.cols())) continue;
      jj %= e.rows();
      ii %= e.cols();
      sum += (e.channels[a](j, i) - m.mean[a]) * (e.channels[b](jj, ii) - m.mean[b]);
      ++count;
    }
  const auto k = static_cast<Eigen::Index>(a), l = static_cast<Eigen::Index>(b);
  return sum / static_cast<double>(count) / std::sqrt(m.covariance(k, k) * m.covariance(l, l));
}

TEST(Synthesis, KeepsMeanAndVarianceExactly) {
  for (const Recipe recipe : {Recipe::Separable, Recipe::Full, Recipe::Joint})
    for (const TextureSize& size : {TextureSize{64, 64}, TextureSize{37, 91}, TextureSize{20, 300}}) {
      const Exemplar exemplar = block(24, 40);
      const ExemplarMoments from = moments_of(exemplar),
                            to = moments_of(as_exemplar(synthesise(model_of(exemplar, recipe), size, 7)));
      for (std::size_t c = 0; c < kChannels; ++c) {
        const auto k = static_cast<Eigen::Index>(c);
        EXPECT_NEAR(to.mean[c], from.mean[c], kFloat * std::sqrt(from.covariance(k, k)) + 1e-6);
        EXPECT_NEAR(to.covariance(k, k) / from.covariance(k, k), 1, 1e-3) << name_of(recipe) << " " << c;
      }
    }
}

TEST(Synthesis, KeepsAStripsAmplitudesAtItsOwnSize) {
  // [Dong15 §9] at its plainest: a strip as wide as the texture, no taper, the other axis white.
  constexpr Eigen::Index kLength = 45;
  Exemplar strip = make_exemplar(1, kLength);
  for (std::size_t c = 0; c < kChannels; ++c)
    strip.channels[c] = block(1, kLength).channels[c];
  const TextureField field = synthesise(model_of(strip, Recipe::Separable, Taper::None), {1, kLength}, 3);
  const auto amplitude = [&](const auto& values, Eigen::Index k) {  // literal sum
    std::complex<double> sum = 0;
    for (Eigen::Index n = 0; n < kLength; ++n)
      sum += std::polar(1., -2 * std::numbers::pi * static_cast<double>(k * n) / kLength) *
             static_cast<double>(values(0, n));
    return std::abs(sum);
  };
  for (std::size_t c = 0; c < kChannels; ++c)
    for (Eigen::Index k = 1; k <= kLength / 2; ++k)
      EXPECT_NEAR(amplitude(field[c], k), amplitude(strip.channels[c], k),
                  2e-3 * amplitude(strip.channels[c], 1))
          << c << " " << k;
}

TEST(Synthesis, KeepsAutocorrelationsWithinTheirError) {
  // Law: known smoothing; a block of 40 × 60 tells its correlations to about 0.1, and the triangle of lags
  // that a taper damps is short of it by as much.
  constexpr double kStatistical = 0.2;
  const Exemplar exemplar = block(40, 60);
  for (const Recipe recipe : {Recipe::Separable, Recipe::Full, Recipe::Joint}) {
    const Exemplar texture = as_exemplar(synthesise(model_of(exemplar, recipe), {128, 128}, 5));
    for (std::size_t c = 0; c < kChannels; ++c)
      for (const auto& [dj, di] : {std::pair{0, 1}, std::pair{0, 3}, std::pair{1, 0}, std::pair{2, 2}})
        EXPECT_NEAR(correlation(texture, c, c, dj, di, true), correlation(exemplar, c, c, dj, di, false),
                    kStatistical)
            << name_of(recipe) << " " << c << " " << dj << " " << di;
  }
}

TEST(Synthesis, JointRecipesKeepCrossCorrelations) {
  // 2400 texels are some fifty independent ones, and half as many under the taper.
  constexpr double kStatistical = 0.2;
  const Exemplar exemplar = block(40, 60);
  const Exemplar joint = as_exemplar(synthesise(model_of(exemplar, Recipe::Joint), {128, 128}, 5)),
                 alone = as_exemplar(synthesise(model_of(exemplar, Recipe::Full), {128, 128}, 5));
  const double measured = correlation(exemplar, 0, 1, 0, 1, false);
  EXPECT_LT(measured, -0.8);
  EXPECT_NEAR(correlation(joint, 0, 1, 0, 1, true), measured, kStatistical);  // at a lag, with its sign
  EXPECT_NEAR(correlation(joint, 0, 2, 0, 0, true), correlation(exemplar, 0, 2, 0, 0, false), kStatistical);
  EXPECT_GT(std::abs(correlation(alone, 0, 1, 0, 1, true) - measured), 0.4);
  // Strips: covariances at lag 0.
  Exemplar cross = exemplar;
  for (auto& channel : cross.channels)
    for (Eigen::Index j = 0; j < 40; ++j)
      for (Eigen::Index i = 0; i < 60; ++i)
        if (j != 20 && i != 30) channel(j, i) = std::nan("");
  ASSERT_FALSE(is_block(cross));
  const Exemplar strips = as_exemplar(synthesise(model_of(cross, Recipe::Joint), {128, 128}, 5));
  EXPECT_NEAR(correlation(strips, 0, 2, 0, 0, true),
              moments_of(cross).covariance(0, 2) /
                  std::sqrt(moments_of(cross).covariance(0, 0) * moments_of(cross).covariance(2, 2)),
              kStatistical);
  EXPECT_THROW(model_of(cross, Recipe::Full), InputError);
}

TEST(Synthesis, IsConstantForAConstantExemplar) {
  Exemplar exemplar = make_exemplar(3, 50);
  for (std::size_t c = 0; c < kChannels; ++c)
    exemplar.channels[c].setConstant(0.1 + static_cast<double>(c));
  for (const Recipe recipe : {Recipe::Separable, Recipe::Full, Recipe::Joint}) {
    TextureField field = synthesise(model_of(exemplar, recipe), {33, 17}, 1);
    MarginalMap(exemplar).apply(field);
    const TextureField part = synthesise_part(model_of(exemplar, recipe), {33, 17}, 1, {3, 4, 5, 6});
    for (std::size_t c = 0; c < kChannels; ++c) {
      EXPECT_EQ(field[c].minCoeff(), static_cast<float>(0.1 + static_cast<double>(c)));
      EXPECT_EQ(field[c].maxCoeff(), field[c].minCoeff());
      EXPECT_EQ(part[c].maxCoeff(), field[c].minCoeff());
    }
  }
}

TEST(Synthesis, TakesStripsOfAnyLengthAndAnySize) {
  for (const Recipe recipe : {Recipe::Separable, Recipe::Joint})
    for (const auto& [rows, cols] : {std::pair{1, 1}, std::pair{1, 2}, std::pair{3, 1}, std::pair{1, 101}})
      for (const TextureSize& size :
           {TextureSize{1, 1}, TextureSize{1, 8}, TextureSize{7, 1}, TextureSize{31, 33}}) {
        const Exemplar exemplar = block(rows, cols);
        const TextureField field = synthesise(model_of(exemplar, recipe), size, 1);
        for (std::size_t c = 0; c < kChannels; ++c) {
          EXPECT_TRUE(field[c].isFinite().all());
          if (rows * cols > 1 && size.rows * size.cols > 100) {
            EXPECT_GT(field[c].maxCoeff(), field[c].minCoeff());
          }
        }
      }
  EXPECT_THROW(model_of(make_exemplar(4, 4), Recipe::Separable), InputError);
}

TEST(Synthesis, TakesWhatVariesAlongOneAxisOnly) {
  Exemplar lines = block(40, 1);
  for (auto& channel : lines.channels)
    channel = channel.replicate(1, 30).eval();
  const TextureField field = synthesise(model_of(lines, Recipe::Separable), {64, 64}, 1);
  const double across = (field[0].bottomRows(63) - field[0].topRows(63)).abs().mean(),
               along = (field[0].rightCols(63) - field[0].leftCols(63)).abs().mean();
  EXPECT_GT(across, 1e-3);
  EXPECT_LE(along, 1e-6);
}

TEST(Synthesis, IsTheSameForAnyNumberOfThreads) {
  const TextureModel model = model_of(block(20, 30), Recipe::Joint);
  const int threads = thread_count();
  set_thread_count(1);
  const TextureField one = synthesise(model, {50, 64}, 9),
                     part = synthesise_part(model, {500, 640}, 9, {3, 4, 40, 50});
  set_thread_count(3);
  const TextureField three = synthesise(model, {50, 64}, 9),
                     again = synthesise_part(model, {500, 640}, 9, {3, 4, 40, 50});
  set_thread_count(threads);
  for (std::size_t c = 0; c < kChannels; ++c) {
    EXPECT_TRUE((one[c] == three[c]).all());
    EXPECT_TRUE((part[c] == again[c]).all());
  }
  EXPECT_FALSE((synthesise(model, {50, 64}, 10)[0] == one[0]).all());
}

TEST(Synthesis, PartsMeetAndKeepTheLaw) {
  // 600 × 600 texels hold some 10,000 patches of correlation: their variance is known to 2 %.
  constexpr double kMeet = 0.03, kVariance = 0.1, kCorrelation = 0.05;
  const Exemplar exemplar = block(30, 40);
  for (const Recipe recipe : {Recipe::Separable, Recipe::Full, Recipe::Joint}) {
    const TextureModel model = model_of(exemplar, recipe);
    const TextureField big = synthesise_part(model, {600, 600}, 4, {0, 0, 600, 600}),
                       small = synthesise_part(model, {600, 600}, 4, {250, 560, 100, 100});
    const ExemplarMoments from = moments_of(exemplar), to = moments_of(as_exemplar(big));
    const Exemplar whole = as_exemplar(synthesise(model, {600, 600}, 4));
    for (std::size_t c = 0; c < kChannels; ++c) {
      const auto k = static_cast<Eigen::Index>(c);
      const double deviation = std::sqrt(from.covariance(k, k));
      EXPECT_NEAR(to.covariance(k, k) / from.covariance(k, k), 1, kVariance) << name_of(recipe);
      EXPECT_NEAR(to.mean[c], from.mean[c], 0.1 * deviation);
      const double meet = (small[c].leftCols(40) - big[c].block(250, 560, 100, 40)).abs().maxCoeff(),
                   wrap = (small[c].rightCols(60) - big[c].block(250, 0, 100, 60)).abs().maxCoeff();
      EXPECT_LE(meet, kMeet * deviation) << name_of(recipe);
      EXPECT_LE(wrap, kMeet * deviation) << name_of(recipe);
      EXPECT_NEAR(correlation(as_exemplar(big), c, c, 0, 2, false), correlation(whole, c, c, 0, 2, true),
                  kCorrelation);
    }
  }
}

TEST(Marginals, AreTheExemplars) {
  Exemplar exemplar = block(40, 60);
  for (auto& channel : exemplar.channels)
    channel = (channel - channel.mean()).exp();  // skewed
  TextureField field = synthesise(model_of(exemplar, Recipe::Full), {256, 256}, 1);
  MarginalMap(exemplar).apply(field);
  constexpr double kQuantile = 0.05;  // of p
  for (std::size_t c = 0; c < kChannels; ++c) {
    EXPECT_GE(field[c].minCoeff(), static_cast<float>(exemplar.channels[c].minCoeff()) - 1e-6F);
    EXPECT_LE(field[c].maxCoeff(), static_cast<float>(exemplar.channels[c].maxCoeff()) + 1e-6F);
    for (const double p : {0.1, 0.5, 0.9}) {
      std::vector<double> sorted(exemplar.channels[c].data(), exemplar.channels[c].data() + 2400);
      std::sort(sorted.begin(), sorted.end());
      const auto value = static_cast<float>(sorted[static_cast<std::size_t>(p * 2400)]);
      EXPECT_NEAR(static_cast<double>((field[c] < value).count()) / 65536, p, kQuantile);
    }
  }
}

}  // namespace
}  // namespace micro
