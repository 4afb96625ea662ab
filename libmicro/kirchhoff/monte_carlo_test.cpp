#include "kirchhoff/monte_carlo.h"

#include <gtest/gtest.h>

#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"
#include "kirchhoff/exact.h"
#include "kirchhoff/monte_carlo_kernel.h"
#include "testing/gaussian_surface.h"

namespace micro {
namespace {

/// Two-sided 5.7e-7 for one normal number; the files' few hundred z values leave 1e-4 for a false alarm.
constexpr double kZ = 5;
/// The same for either tail of a chi-square.
constexpr double kTail = 1e-7;

/// A rough surface of steep facets with a hole and a missing corner.
HeightField rough(Eigen::Index rows, Eigen::Index cols) {
  HeightField surface = testing::gaussian_surface(rows, cols, 0.3, 0.2, {0.25, 0.9, 0.7}, 5);
  surface.z(0, 0) = surface.z(rows / 2, cols / 3) = surface.z(rows / 2 + 1, cols / 3) = kMissing;
  return surface;
}

std::vector<Vec3> directions(double lambda_q) {
  std::vector<Vec3> q;
  for (const Vec2& h : {Vec2(0, 0), Vec2(0.1, 0.05), Vec2(-0.3, 0.2), Vec2(0.5, 0.6), Vec2(0.99, 0)})
    q.push_back(wave_vector({h.x(), h.y(), std::sqrt(1 - h.squaredNorm())}, lambda_q));
  return q;
}

TEST(MonteCarloKernel, RandomWordsAreThoseOfPhilox) {
  constexpr std::size_t kCount = 512;
  std::vector<std::uint32_t> block(4 * kCount);
  const std::uint64_t seed = 0x123456789abcdefULL, first = (std::uint64_t{7} << 40) + 512 * 99;
  detail::random_word_block(seed, 42, first, kCount, block.data());
  for (std::size_t k = 0; k < kCount; ++k) {
    const auto expected = random_words(seed, 42, first + k);
    for (std::size_t w = 0; w < 4; ++w)
      ASSERT_EQ(block[w * kCount + k], expected[w]) << k;
  }
}

/// Mean and variance of the mean of numbers that come one by one.
struct Sample {
  double n = 0, sum = 0, sum2 = 0;
  void add(double x) { n += 1, sum += x, sum2 += x * x; }
  double mean() const { return sum / n; }
  double variance() const { return (sum2 - sum * sum / n) / (n - 1); }
  double z(double expected) const { return (mean() - expected) / std::sqrt(variance() / n); }
};

struct SamplingCase {
  int subdivision;
  Draws draws;
  double lambda_q;
};

class MonteCarloField : public ::testing::TestWithParam<SamplingCase> {};

TEST_P(MonteCarloField, HalvesAreUnbiasedAndIndependentAndKnowTheirVariance) {
  const auto [subdivision, draws, lambda_q] = GetParam();
  const Window window{rough(40, 36), {}};
  const std::vector<Vec3> q = directions(lambda_q);
  const auto exact = exact_field(window.surface, q);
  constexpr int kSeeds = 200;
  struct Samples {
    Sample re, im, density, power, cross;
    double chi2_re = 0, chi2_im = 0;
  };
  std::vector<Samples> samples(q.size());
  for (int seed = 0; seed < kSeeds; ++seed) {
    const auto field =
        monte_carlo_field(window, q, {subdivision, static_cast<std::uint64_t>(seed), 0, draws});
    for (std::size_t k = 0; k < q.size(); ++k) {
      const std::complex<double> a = field[k].first - exact[k], b = field[k].second - exact[k];
      Samples& s = samples[k];
      s.re.add(a.real() + b.real());
      s.im.add(a.imag() + b.imag());
      s.density.add((field[k].first * std::conj(field[k].second)).real());
      s.power.add(std::norm(field[k].first));
      s.chi2_re += a.real() * a.real() / field[k].covariance(0, 0);
      s.chi2_im += b.imag() * b.imag() / field[k].covariance(1, 1);
      s.cross.add(field[k].covariance(0, 1) - b.real() * b.imag());
    }
  }
  const boost::math::chi_squared chi_squared(kSeeds);
  for (std::size_t k = 0; k < q.size(); ++k) {
    for (const double chi2 : {samples[k].chi2_re, samples[k].chi2_im}) {
      EXPECT_GT(cdf(chi_squared, chi2), kTail) << "variance of F, direction " << k;
      EXPECT_GT(cdf(complement(chi_squared, chi2)), kTail) << "variance of F, direction " << k;
    }
    EXPECT_LE(std::abs(samples[k].cross.z(0)), kZ) << "covariance, direction " << k;
    EXPECT_LE(std::abs(samples[k].re.z(0)), kZ) << "Re F, direction " << k;
    EXPECT_LE(std::abs(samples[k].im.z(0)), kZ) << "Im F, direction " << k;
    EXPECT_LE(std::abs(samples[k].density.z(std::norm(exact[k]))), kZ) << "D, direction " << k;
  }
  // The plain square is too large, and this test has the power to see it.
  if (subdivision == 1 && draws == Draws::Single) {
    EXPECT_GT(samples[3].power.z(std::norm(exact[3])), kZ);
  }
}

INSTANTIATE_TEST_SUITE_P(Samplings, MonteCarloField,
                         ::testing::Values(SamplingCase{1, Draws::Single, 0.6},
                                           SamplingCase{1, Draws::Rotated, 0.6},
                                           SamplingCase{3, Draws::Single, 0.6},
                                           SamplingCase{3, Draws::Rotated, 0.6},
                                           SamplingCase{1, Draws::Rotated, 0.02}));

TEST(MonteCarlo, StandardErrorsAreThoseOfTheErrors) {
  const HeightField surface = rough(50, 60);
  const std::vector<Vec3> q = directions(0.6);
  Sample z2;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const auto estimate = monte_carlo_density(surface, q, {.tolerance = 0.03, .seed = seed});
    for (std::size_t k = 1; k < q.size(); ++k) {
      const DirectionEstimate& d = estimate.value[k];
      const double z = (d.density - exact_density(surface, q[k])) / d.standard_error;
      z2.add(z * z);
    }
  }
  EXPECT_LE(std::abs(z2.z(1)), kZ) << z2.mean();
}

TEST(MonteCarlo, MeetsItsTolerance) {
  const HeightField surface = rough(60, 70);
  for (const Draws draws : {Draws::Single, Draws::Rotated})
    for (const double tolerance : {0.1, 0.01, 0.001}) {
      if (draws == Draws::Single && tolerance < 0.01) continue;  // four seconds
      const std::vector<Vec3> q = directions(0.6);
      const auto estimate =
          monte_carlo_density(surface, q, {.tolerance = tolerance, .seed = 3, .draws = draws});
      for (std::size_t k = 0; k < q.size(); ++k) {
        const DirectionEstimate& d = estimate.value[k];
        EXPECT_TRUE(d.reached);
        EXPECT_LE(d.standard_error, tolerance * std::max(d.density, d.local_mean));
        EXPECT_LE(std::abs(d.density - exact_density(surface, q[k])),
                  kZ * d.standard_error + 1e-6 * d.density);
      }
      EXPECT_GT(estimate.error, 0);
      EXPECT_GT(estimate.cost.evaluations, 0);
    }
}

TEST(MonteCarlo, SaysHowFarItGot) {
  const HeightField surface = rough(60, 70);
  const std::vector<Vec3> q = directions(0.6);
  const auto estimate = monte_carlo_density(surface, q, {.tolerance = 1e-5, .max_points = 3e6});
  EXPECT_LE(static_cast<double>(estimate.cost.evaluations), 3e6);
  int refined = 0;
  for (std::size_t k = 0; k < q.size(); ++k) {
    EXPECT_FALSE(estimate.value[k].reached);
    refined += estimate.value[k].subdivision > 1;
    EXPECT_LE(std::abs(estimate.value[k].density - exact_density(surface, q[k])),
              kZ * estimate.value[k].standard_error);
  }
  EXPECT_GT(refined, 0);
}

TEST(MonteCarlo, AnyNumberOfThreadsGivesTheSameBits) {
  const HeightField surface = rough(100, 90);
  const std::vector<Vec3> q = directions(0.6);
  std::vector<DirectionEstimate> first;
  for (const int threads : {1, 2, 5}) {
    set_thread_count(threads);
    const auto estimate = monte_carlo_density(surface, q, {.tolerance = 0.02, .seed = 9});
    if (first.empty()) first = estimate.value;
    for (std::size_t k = 0; k < q.size(); ++k) {
      EXPECT_EQ(estimate.value[k].density, first[k].density);
      EXPECT_EQ(estimate.value[k].standard_error, first[k].standard_error);
    }
  }
  set_thread_count(0);
}

// Where the plane is a phase front every point has the same phase: no variance, and what is left is rounding.
TEST(MonteCarlo, PhaseFrontsHaveNoVariance) {
  constexpr double kRounding = 1e-6;
  for (const double pitch : {0.1, 20.0}) {  // float and double arithmetic
    Grid<double> z(70, 50);
    for (Eigen::Index j = 0; j < z.rows(); ++j)
      for (Eigen::Index i = 0; i < z.cols(); ++i)
        z(j, i) = pitch * 0.5 * static_cast<double>(i) - pitch * 0.25 * static_cast<double>(j);
    const HeightField surface = make_height_field(z, pitch, pitch);
    const std::vector<Vec3> q = {wave_vector(Vec3(-0.5, 0.25, 1).normalized(), 0.555)};
    const double exact = exact_density(surface, q[0]);
    const auto estimate = monte_carlo_density(surface, q, {.tolerance = 1e-4});
    EXPECT_NEAR(estimate.value[0].density / exact, 1, pitch < 1 ? kRounding : 30 * kRounding);
    EXPECT_TRUE(estimate.value[0].reached);
    EXPECT_EQ(estimate.value[0].subdivision, 1);
  }
}

TEST(MonteCarlo, ZooRows) {
  const auto nan = std::numeric_limits<double>::quiet_NaN();
  Grid<double> steps(20, 21), holes(40, 40), border = Grid<double>::Constant(20, 20, nan);
  for (Eigen::Index k = 0; k < steps.size(); ++k)
    steps.data()[k] = k % 3 == 0 ? 10 : 0;
  for (Eigen::Index k = 0; k < holes.size(); ++k)
    holes.data()[k] = k % 40 < 8 && k / 40 < 8 ? 0.1 * static_cast<double>(k % 3) : nan;
  border.block(2, 3, 14, 12).setConstant(0.25);
  border(7, 7) = 0.5;
  const struct {
    const char* name;
    HeightField surface;
  } zoo[] = {{"flat", make_height_field(Grid<double>::Zero(20, 30), 0.1, 0.1)},
             {"one cell", make_height_field(Grid<double>::Zero(2, 2), 0.1, 0.1)},
             {"10 µm steps", make_height_field(steps, 0.1, 0.1)},
             {"96 % missing", make_height_field(holes, 0.1, 0.1)},
             {"missing border", make_height_field(border, 0.1, 0.1)},
             {"offset of 1e6 µm", make_height_field(holes + 1e6, 0.1, 0.1)},
             {"dx/dy = 10", make_height_field(steps * 0.01, 1, 0.1)}};
  for (const auto& [name, surface] : zoo)
    for (const double lambda_q : {0.01, 0.555, 1e6})
      for (const Vec3& q : directions(lambda_q)) {
        const auto estimate =
            monte_carlo_density(surface, {&q, 1}, {.tolerance = 0.1, .max_points = 1e6, .seed = 1});
        const DirectionEstimate& d = estimate.value[0];
        const double scale = std::sqrt(d.local_mean * std::max(d.density, d.local_mean));
        EXPECT_LE(std::abs(d.density - exact_density(surface, q)), 6 * d.standard_error + 1e-5 * scale)
            << name << ", λ_q = " << lambda_q << ", q = " << q.transpose();
      }
}

TEST(MonteCarlo, RefusesWithAReason) {
  const HeightField plane = make_height_field(Grid<double>::Zero(5, 5), 1, 1);
  const Vec3 q(0, 0, 20), broken(0, std::nan(""), 20);
  EXPECT_THROW(
      monte_carlo_density(make_height_field(Grid<double>::Constant(5, 5, std::nan("")), 1, 1), {&q, 1}, {}),
      InputError);
  EXPECT_THROW(monte_carlo_density(make_height_field(Grid<double>::Zero(1, 9), 1, 1), {&q, 1}, {}),
               InputError);
  EXPECT_THROW(monte_carlo_density(plane, {&broken, 1}, {}), InputError);
  EXPECT_THROW(monte_carlo_density(plane, {&q, 1}, {.tolerance = 0}), InputError);
  EXPECT_THROW(monte_carlo_density(plane, {&q, 1}, {.tolerance = std::nan("")}), InputError);
  EXPECT_TRUE(monte_carlo_density(plane, {}, {}).value.empty());
}

// Phases are rounded to float: what is left counts in the standard errors, and no points are drawn against
// it.
TEST(MonteCarlo, ReachesNoToleranceBelowItsRounding) {
  const HeightField surface = rough(30, 40);
  const std::vector<Vec3> q = directions(0.6);
  for (const double tolerance : {1e-7, 1e-9}) {
    const auto estimate = monte_carlo_density(surface, q, {.tolerance = tolerance});
    EXPECT_LT(estimate.cost.evaluations, 1e10) << tolerance;
    for (std::size_t k = 0; k < q.size(); ++k) {
      const DirectionEstimate& d = estimate.value[k];
      EXPECT_FALSE(d.reached) << tolerance;
      EXPECT_LE(std::abs(d.density - exact_density(surface, q[k])), 3 * d.standard_error) << tolerance;
    }
  }
}

}  // namespace
}  // namespace micro
