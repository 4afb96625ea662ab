#include "texture/synthesis.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
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

/// Σ a(x)·b(x + lag) over √(Σa²·Σb²), nothing beyond the borders.
double overlap(const Grid<double>& a, const Grid<double>& b, Eigen::Index dj, Eigen::Index di) {
  const Eigen::Index rows = a.rows() - dj, cols = a.cols() - di;
  return (a.topLeftCorner(rows, cols) * b.bottomRightCorner(rows, cols)).sum() /
         std::sqrt(a.square().sum() * b.square().sum());
}

/// √ of a symmetric positive matrix.
Covariance root_of(const Covariance& matrix) {
  return Eigen::SelfAdjointEigenSolver<Covariance>(matrix).operatorSqrt();
}

TEST(Synthesis, FullAndJointKeepTheBlocksCorrelationsExactly) {
  // |amplitude|² is the transform of the tapered deviations' correlation, whatever the phases.
  const Exemplar exemplar = block(40, 60);
  const Eigen::ArrayXd down = taper_weights(40, Taper::Hann), along = taper_weights(60, Taper::Hann);
  const Grid<double> weights = (down.matrix() * along.matrix().transpose()).array();
  std::array<Grid<double>, kChannels> deviations;
  for (std::size_t c = 0; c < kChannels; ++c)
    deviations[c] = weights * (exemplar.channels[c] - (weights * exemplar.channels[c]).sum() / weights.sum());
  // Of all channels M with M·S·Mᵀ = R, S of the tapered ones and R the exemplar's, the nearest by its other
  // formula M = S^{−1/2} (S^{1/2} R S^{1/2})^{1/2} S^{−1/2}.
  Covariance s, r;
  for (std::size_t a = 0; a < kChannels; ++a)
    for (std::size_t b = 0; b < kChannels; ++b) {
      const auto k = static_cast<Eigen::Index>(a), l = static_cast<Eigen::Index>(b);
      s(k, l) = overlap(deviations[a], deviations[b], 0, 0);
      r(k, l) = correlation(exemplar, a, b, 0, 0, true);
    }
  const Covariance root = root_of(s), inverse = root.inverse(),
                   m = inverse * root_of(root * r * root) * inverse;
  std::array<Grid<double>, kChannels> mixed;
  for (std::size_t a = 0; a < kChannels; ++a) {
    mixed[a] = Grid<double>::Zero(40, 60);
    for (std::size_t b = 0; b < kChannels; ++b)
      mixed[a] += m(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) * deviations[b] /
                  std::sqrt(deviations[b].square().sum());
  }
  const Exemplar joint = as_exemplar(synthesise(model_of(exemplar, Recipe::Joint), {128, 128}, 5)),
                 full = as_exemplar(synthesise(model_of(exemplar, Recipe::Full), {128, 128}, 5));
  for (const auto& [dj, di] : {std::pair{0, 0}, std::pair{0, 1}, std::pair{0, 3}, std::pair{1, 0},
                               std::pair{2, 2}, std::pair{30, 9}})
    for (std::size_t a = 0; a < kChannels; ++a) {
      EXPECT_NEAR(correlation(full, a, a, dj, di, true), overlap(deviations[a], deviations[a], dj, di),
                  kFloat);
      for (std::size_t b = 0; b < kChannels; ++b)
        EXPECT_NEAR(correlation(joint, a, b, dj, di, true), overlap(mixed[a], mixed[b], dj, di), kFloat)
            << a << " " << b << " " << dj << " " << di;
    }
  for (std::size_t a = 0; a < kChannels; ++a)
    for (std::size_t b = 0; b < kChannels; ++b)
      EXPECT_NEAR(correlation(joint, a, b, 0, 0, true), correlation(exemplar, a, b, 0, 0, true), kFloat);
  // The recipe that treats channels alone loses what the joint one keeps: −1 a texel later.
  EXPECT_LT(correlation(joint, 0, 1, 0, 1, true), -0.8);
  EXPECT_GT(correlation(full, 0, 1, 0, 1, true), -0.4);
}

/// Mean and its standard error of n values.
struct MeanOf {
  double mean = 0, error = 0;

  template <typename Value>
  MeanOf(int n, Value&& value) {
    double sum = 0, squares = 0;
    for (int k = 0; k < n; ++k) {
      const double x = value(k);
      sum += x;
      squares += x * x;
    }
    mean = sum / n;
    error = std::sqrt(std::max(0., squares / n - mean * mean) / (n - 1));
  }
};

TEST(Synthesis, SeparableKeepsTheLawsAutocorrelation) {
  // Of strips of a known law: white noise smoothed by w(d) = exp(−0.1 d²), |d| ≤ 4, has the correlation
  // Σ w(d)·w(d + lag) / Σ w². What a strip cannot tell from its mean is a correlation length over its length.
  constexpr Eigen::Index kLength = 1000;
  constexpr int kExemplars = 40;
  constexpr double kOfMean = 8. / kLength;
  const double z = 3.9;  // 1 in 10,000, over eight tests
  const auto weight = [](Eigen::Index d) {
    return std::abs(d) <= 4 ? std::exp(-0.1 * static_cast<double>(d * d)) : 0;
  };
  std::vector<TextureModel> models;
  for (int k = 0; k < kExemplars; ++k)
    models.push_back(
        model_of(block(1, kLength, static_cast<std::uint64_t>(k) + 10), Recipe::Separable, Taper::None));
  for (const Eigen::Index lag : {1, 2, 5, 12}) {
    double products = 0, squares = 0;
    for (Eigen::Index d = -4; d <= 4; ++d) {
      products += weight(d) * weight(d + lag);
      squares += weight(d) * weight(d);
    }
    for (const std::size_t c : {0U, 3U}) {
      const MeanOf found(kExemplars, [&](int k) {
        const TextureField field = synthesise(models[static_cast<std::size_t>(k)], {4, kLength}, 1);
        return correlation(as_exemplar(field), c, c, 0, lag, true);
      });
      EXPECT_NEAR(found.mean, products / squares, z * found.error + kOfMean) << c << " " << lag;
      EXPECT_LT(found.error, 0.02);
    }
  }
}

TEST(Synthesis, KeepsWhatIsSlowerThanAStrip) {
  // Streaks longer than the exemplar: rows differ by more than what varies along them, which a strip's own
  // spectrum, without its mean, knows nothing of.
  constexpr double kNear = 0.1, kStreaks = 0.8;  // of the variance
  Exemplar exemplar = make_exemplar(24, 30);
  for (std::size_t c = 0; c < kChannels; ++c)
    for (Eigen::Index j = 0; j < 24; ++j)
      for (Eigen::Index i = 0; i < 30; ++i) {
        const auto at = [&](std::uint32_t stream, Eigen::Index place) {
          return random_normal(c, stream, static_cast<std::uint64_t>(place))[0];
        };
        exemplar.channels[c](j, i) =
            std::sqrt(kStreaks) * at(0, j) + std::sqrt(1 - kStreaks) * at(1, 100 * j + i);
      }
  const TextureModel model = model_of(exemplar, Recipe::Separable);
  for (const Exemplar& texture : {as_exemplar(synthesise(model, {256, 256}, 1)),
                                  as_exemplar(synthesise_part(model, {5000, 5000}, 1, {0, 0, 256, 256}))})
    for (std::size_t c = 0; c < kChannels; ++c)
      EXPECT_NEAR(correlation(texture, c, c, 0, 3, false), correlation(exemplar, c, c, 0, 3, false), kNear)
          << c;
}

TEST(Synthesis, JointStripsKeepCovariancesAtLagZero) {
  Exemplar cross = block(40, 60);
  for (auto& channel : cross.channels)
    for (Eigen::Index j = 0; j < 40; ++j)
      for (Eigen::Index i = 0; i < 60; ++i)
        if (j != 20 && i != 30) channel(j, i) = std::nan("");
  ASSERT_FALSE(is_block(cross));
  EXPECT_THROW(model_of(cross, Recipe::Full), InputError);
  constexpr int kSeeds = 40;
  const double z = 4.1;  // 1 in 10,000, over fifteen tests
  const TextureModel model = model_of(cross, Recipe::Joint);
  std::vector<ExemplarMoments> textures;
  for (int k = 0; k < kSeeds; ++k)
    textures.push_back(moments_of(as_exemplar(synthesise(model, {64, 64}, static_cast<std::uint64_t>(k)))));
  const Covariance wanted = moments_of(cross).covariance;
  for (Eigen::Index a = 0; a < 5; ++a)
    for (Eigen::Index b = 0; b <= a; ++b) {
      const MeanOf found(kSeeds,
                         [&](int k) { return textures[static_cast<std::size_t>(k)].covariance(a, b); });
      const double unit = std::sqrt(wanted(a, a) * wanted(b, b));
      EXPECT_NEAR(found.mean, wanted(a, b), z * found.error + kFloat * unit) << a << " " << b;
      EXPECT_LT(found.error, 0.05 * unit);
    }
}

TEST(Synthesis, JointStripsKeepEachNumbersOwnSpectrum) {
  // Slopes of an isotropic surface: one varies slowly along x, the other along y, and they have nothing in
  // common; a third goes with the first. Mixed before their spectra are taken, all would have the mean of
  // them.
  constexpr Eigen::Index kLength = 300;
  constexpr double kNear = 0.12;  // correlations of 300 texels
  Exemplar cross = make_exemplar(kLength, kLength);
  for (Eigen::Index k = 0; k < kLength; ++k)
    for (const auto& [j, i] : {std::pair{Eigen::Index{7}, k}, std::pair{k, Eigen::Index{9}}}) {
      const auto at = [&](std::uint32_t stream, Eigen::Index place) {
        return random_normal(11, stream, static_cast<std::uint64_t>(place))[0];
      };
      const bool along_x = j == 7;
      const auto slow = [&](std::uint32_t stream) {
        double sum = 0;
        for (Eigen::Index d = 0; d < 4; ++d)
          sum += at(stream, k + d) / 2;
        return sum;
      };
      const std::uint32_t axis = along_x ? 0 : 10;
      const double a = along_x ? slow(axis) : at(axis, k), b = along_x ? at(axis + 1, k) : slow(axis + 1);
      cross.channels[0](j, i) = a;
      cross.channels[1](j, i) = b;
      cross.channels[2](j, i) = 0.8 * a + 0.6 * (along_x ? slow(axis + 2) : at(axis + 2, k));
      cross.channels[3](j, i) = at(axis + 3, k);
      cross.channels[4](j, i) = at(axis + 4, k);
    }
  const TextureModel model = model_of(cross, Recipe::Joint, Taper::None);
  for (const Exemplar& texture :
       {as_exemplar(synthesise(model, {256, 256}, 1)),
        as_exemplar(synthesise_part(model, {6000, 6000}, 1, {100, 5900, 256, 256}))}) {
    const auto at_lag = [&](std::size_t a, std::size_t b, Eigen::Index dj, Eigen::Index di) {
      return correlation(texture, a, b, dj, di, false);
    };
    EXPECT_NEAR(at_lag(0, 0, 0, 1), 0.75, kNear);  // of a mean over four texels
    EXPECT_NEAR(at_lag(0, 0, 1, 0), 0, kNear);
    EXPECT_NEAR(at_lag(1, 1, 0, 1), 0, kNear);
    EXPECT_NEAR(at_lag(1, 1, 1, 0), 0.75, kNear);
    EXPECT_NEAR(at_lag(0, 1, 0, 0), 0, kNear);
    EXPECT_NEAR(at_lag(0, 2, 0, 0), 0.8, kNear);
  }
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
  const TextureModel model = model_of(lines, Recipe::Separable);
  const TextureField left = synthesise_part(model, {6000, 6000}, 1, {700, 0, 40, 30}),
                     right = synthesise_part(model, {6000, 6000}, 1, {700, 5000, 40, 30});
  EXPECT_LE((left[0].col(0).replicate(1, 30) - right[0]).abs().maxCoeff(), 1e-6);
  EXPECT_GT((left[0].bottomRows(39) - left[0].topRows(39)).abs().mean(), 1e-3);
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
  // 600 × 600 texels hold some 10,000 patches of correlation: their variance is known to 2 %. Parts differ by
  // the rounding of transforms of different sizes.
  constexpr double kMeet = 2e-5, kVariance = 0.1, kCorrelation = 0.05;
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
