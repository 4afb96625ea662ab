// Every surface that is made, against its closed form: exactly where it is deterministic, by z values over
// independent seeds where it is random.
#include <gtest/gtest.h>

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "height/brushed_surface.h"
#include "height/gaussian_surface.h"
#include "height/make_holes.h"
#include "height/shaped_surface.h"
#include "height/statistics.h"

namespace micro {
namespace {

constexpr double kPi = std::numbers::pi;
/// Two-sided probability 6e-7 for a normal z; with 60 seeds and some hundred tests, Student's tails raise a
/// chance failure somewhere to about one in a thousand seeds chosen, and the seeds are fixed.
constexpr double kZ = 5;
constexpr int kSeeds = 60;
constexpr double kFloatRounding = 1e-5;

double height(const HeightField& surface, Eigen::Index j, Eigen::Index i) {
  return surface.mean + surface.z(j, i);
}

/// z value of the mean of each estimate over independent seeds against what is expected.
Eigen::ArrayXd z_values(const Eigen::ArrayXd& expected,
                        const std::function<Eigen::ArrayXd(std::uint64_t seed)>& estimates) {
  Eigen::ArrayXXd values(expected.size(), kSeeds);
  parallel_for(kSeeds,
               [&](std::int64_t s) { values.col(s) = estimates(static_cast<std::uint64_t>(s) + 100); });
  const Eigen::ArrayXd mean = values.rowwise().mean();
  const Eigen::ArrayXd variance = (values.colwise() - mean).square().rowwise().sum() / (kSeeds - 1);
  return (mean - expected) / (variance / kSeeds).sqrt();
}

double z_value(double expected, const std::function<double(std::uint64_t seed)>& estimate) {
  return z_values(Eigen::ArrayXd::Constant(1, expected),
                  [&](std::uint64_t seed) { return Eigen::ArrayXd::Constant(1, estimate(seed)); })(0);
}

/// Mean of z(p)·z(p + lag) over the points of a surface.
double product_at_lag(const HeightField& surface, Eigen::Index dj, Eigen::Index di) {
  double sum = 0, n = 0;
  for (Eigen::Index j = 0; j + dj < surface.rows(); ++j)
    for (Eigen::Index i = std::max<Eigen::Index>(0, -di); i < std::min(surface.cols(), surface.cols() - di);
         ++i)
      sum += height(surface, j, i) * height(surface, j + dj, i + di), n += 1;
  return sum / n;
}

double correlation(const GaussianField& f, double x, double y) {
  const double u = (x * std::cos(f.orientation) + y * std::sin(f.orientation)) / f.tau_x;
  const double v = (y * std::cos(f.orientation) - x * std::sin(f.orientation)) / f.tau_y;
  return f.rms * f.rms * std::exp(-u * u - v * v);
}

constexpr SyntheticGrid kGrid{60, 80, 0.25, 0.2};

struct GaussianCase {
  GaussianField field;
  Border border;
};

std::vector<GaussianCase> gaussian_cases() {
  std::vector<GaussianCase> cases;
  for (const Border border : {Border::Open, Border::Periodic})
    for (const GaussianField& field :
         {GaussianField{0.3, 1, 1, 0}, GaussianField{2, 3, 0.6, 0}, GaussianField{1, 2, 0.5, 0.5},
          GaussianField{1, 2, 0.5, 2.2}, GaussianField{1, 0.5, 1.7, 0.3}, GaussianField{1, 0.21, 0.13, 0.4}})
      cases.push_back({field, border});
  return cases;
}

/// Variance, correlation at six lags, and the slope variance of finite differences, 2 rms² (1 − ρ(d))/d² per
/// axis.
TEST(GaussianSurface, HasItsCorrelationAndSlopeVariance) {
  const std::vector<std::pair<int, int>> lags = {{0, 0}, {0, 1}, {1, 0}, {3, 2}, {3, -2}, {0, 5}, {7, -5}};
  const Eigen::Index n = static_cast<Eigen::Index>(lags.size());
  for (const GaussianCase& c : gaussian_cases()) {
    Eigen::ArrayXd expected(n + 1);
    for (Eigen::Index k = 0; k < n; ++k) {
      const auto& [dj, di] = lags[static_cast<std::size_t>(k)];
      expected(k) = correlation(c.field, di * kGrid.dx, dj * kGrid.dy);
    }
    expected(n) = 2 * (expected(0) - expected(1)) / (kGrid.dx * kGrid.dx) +
                  2 * (expected(0) - expected(2)) / (kGrid.dy * kGrid.dy);
    const Eigen::ArrayXd z = z_values(expected, [&](std::uint64_t seed) {
      const HeightField surface = gaussian_surface(kGrid, c.field, seed, c.border);
      Eigen::ArrayXd values(n + 1);
      for (Eigen::Index k = 0; k < n; ++k)
        values(k) = product_at_lag(surface, lags[static_cast<std::size_t>(k)].first,
                                   lags[static_cast<std::size_t>(k)].second);
      values(n) = std::pow(Sdq(surface), 2);
      return values;
    });
    EXPECT_LE(z.abs().maxCoeff(), kZ)
        << "tau " << c.field.tau_x << " " << c.field.tau_y << ", orientation " << c.field.orientation
        << (c.border == Border::Open ? ", open" : ", periodic") << ":\n"
        << z.transpose();
  }
}

/// Stationary up to the corners: one point of many surfaces at a time.
TEST(GaussianSurface, IsNormalAtEveryPoint) {
  constexpr SyntheticGrid grid{9, 11, 0.5, 0.5};
  const GaussianField field{1, 1.5, 0.7, 0.3};
  constexpr int kBins = 16, kSurfaces = 2000;
  const boost::math::normal normal;
  constexpr std::pair<int, int> kPoints[] = {{0, 0}, {8, 10}, {4, 5}};
  for (const Border border : {Border::Open, Border::Periodic}) {
    Eigen::ArrayXXd heights(3, kSurfaces);
    parallel_for(kSurfaces, [&](std::int64_t s) {
      const HeightField surface = gaussian_surface(grid, field, static_cast<std::uint64_t>(s), border);
      for (int k = 0; k < 3; ++k)
        heights(k, s) = height(surface, kPoints[k].first, kPoints[k].second);
    });
    Eigen::ArrayXXd counts = Eigen::ArrayXXd::Zero(kBins, 3);
    for (int s = 0; s < kSurfaces; ++s)
      for (int k = 0; k < 3; ++k)
        ++counts(static_cast<int>(std::min(cdf(normal, heights(k, s)) * kBins, kBins - 1.)), k);
    const double each = static_cast<double>(kSurfaces) / kBins;
    for (int k = 0; k < 3; ++k)
      EXPECT_GE(
          cdf(complement(boost::math::chi_squared(kBins - 1), (counts.col(k) - each).square().sum() / each)),
          1e-6);
  }
}

TEST(GaussianSurface, ALargerOneContainsTheSmaller) {
  const GaussianField field{1, 2, 0.5, 0.7};
  const HeightField small = gaussian_surface({40, 50, 0.1, 0.1}, field, 3);
  const HeightField large = gaussian_surface({75, 90, 0.1, 0.1}, field, 3);
  for (int j = 0; j < 40; ++j)
    for (int i = 0; i < 50; ++i)
      ASSERT_NEAR(height(small, j, i), height(large, j, i), kFloatRounding);
}

TEST(GaussianSurface, PeriodicOnesContinue) {
  // The seam must be as smooth as the inside: the mean squared step across it has the same expectation.
  const GaussianField field{1, 1.5, 0.8, 0.4};
  const double expected = 2 * (1 - correlation(field, kGrid.dx, 0));
  const double z = z_value(expected, [&](std::uint64_t seed) {
    const HeightField s = gaussian_surface(kGrid, field, seed, Border::Periodic);
    double sum = 0;
    for (Eigen::Index j = 0; j < s.rows(); ++j)
      sum += std::pow(s.z(j, 0) - s.z(j, s.cols() - 1), 2);
    return sum / static_cast<double>(s.rows());
  });
  EXPECT_LE(std::abs(z), kZ);
}

TEST(GaussianSurface, ExtremesAreFinite) {
  for (const Border border : {Border::Open, Border::Periodic}) {
    for (const double tau : {1e-300, 1e-3, 1e6, 1e300})
      for (const auto& [rows, cols] : {std::pair{1, 1}, {1, 40}, {40, 1}, {20, 30}}) {
        const HeightField s = gaussian_surface({rows, cols, 0.1, 0.3}, {1, tau, 1, 0.3}, 1, border);
        EXPECT_EQ(missing_count(s), 0);
        EXPECT_TRUE(std::isfinite(s.mean));
        EXPECT_LE(s.z.abs().maxCoeff(), 12);
      }
    const HeightField white = gaussian_surface({300, 300, 1, 1}, {1, 1e-3, 1e-3, 0}, 1, border);
    EXPECT_NEAR(Sq(white), 1, 5 / std::sqrt(2. * 300 * 300));
    EXPECT_NEAR(Sdq(white), 2, 0.03);
    const HeightField constant = gaussian_surface({20, 30, 1, 1}, {1, 1e12, 1e12, 0.2}, 1, border);
    EXPECT_LE(constant.z.abs().maxCoeff(), 1e-5);
    EXPECT_GE(std::abs(constant.mean), 1e-3);
  }
  EXPECT_THROW(gaussian_surface({0, 3, 1, 1}, {}, 1), InputError);
  EXPECT_THROW(gaussian_surface({3, 3, 1, 1}, {1, 0, 1, 0}, 1), InputError);
  EXPECT_THROW(gaussian_surface({3, 3, 1, 1}, {-1, 1, 1, 0}, 1), InputError);
}

TEST(MultiscaleSurface, VariancesAdd) {
  const PowerLaw law{
      .rms = 0.5, .tau_min = 0.3, .tau_max = 2, .count = 4, .hurst = 0.7, .aspect = 3, .orientation = 0.3};
  const std::vector<GaussianField> scales = power_law_scales(law);
  ASSERT_EQ(scales.size(), 4u);
  EXPECT_DOUBLE_EQ(scales.front().tau_y, 0.3);
  EXPECT_NEAR(scales.back().tau_x, 6, 1e-12);
  EXPECT_NEAR(scales.back().rms / scales.front().rms, std::pow(2 / 0.3, 0.7), 1e-12);
  for (const auto& [dj, di] : {std::pair{0, 0}, {1, 2}}) {
    double expected = 0;
    for (const GaussianField& f : scales)
      expected += correlation(f, di * kGrid.dx, dj * kGrid.dy);
    if (dj == 0) {
      EXPECT_NEAR(expected, 0.25, 1e-12);
    }
    EXPECT_LE(std::abs(z_value(expected,
                               [&, dj = dj, di = di](std::uint64_t seed) {
                                 return product_at_lag(multiscale_surface(kGrid, scales, seed), dj, di);
                               })),
              kZ);
  }
}

TEST(BrushedSurface, ObeysCampbellsTheorem) {
  const Brushing b{.rms = 0.2, .length = 8, .width = 1, .coverage = 5, .spread = 0.1, .orientation = 0.6};
  // Cumulants of shot noise: κ_n = ν ⟨(−d)ⁿ⟩ ⟨a⟩⟨b⟩ (∫(1 − t²)^{2n} dt)², ⟨dⁿ⟩ = n! d̄ⁿ, ν the scratches per
  // µm².
  const double density = b.coverage / (b.length * b.width), half_areas = b.length * b.width / 4,
               depth = mean_depth(b);
  const double i1 = 16. / 15, i3 = 2048. / 3003;
  const double mean = -density * depth * half_areas * i1 * i1;
  const double third = -density * 6 * std::pow(depth, 3) * half_areas * i3 * i3;
  for (const Border border : {Border::Open, Border::Periodic}) {
    const Eigen::Array3d expected(0, b.rms * b.rms, third);
    const Eigen::ArrayXd z = z_values(expected, [&](std::uint64_t seed) -> Eigen::ArrayXd {
      const HeightField s = brushed_surface(kGrid, b, seed, border);
      const Grid<double> d = s.z.cast<double>() + (s.mean - mean);
      return Eigen::Array3d(d.mean(), d.square().mean(), d.cube().mean());
    });
    EXPECT_LE(z.abs().maxCoeff(), kZ) << z.transpose();
  }
}

TEST(BrushedSurface, IsStationaryAtTheBorderAndRunsAlongItsOrientation) {
  const Brushing b{.rms = 0.2, .length = 12, .width = 1, .coverage = 5, .spread = 0.02, .orientation = -0.5};
  const auto row_variance = [&](Eigen::Index j) {
    return [&, j](std::uint64_t seed) {
      const HeightField s = brushed_surface(kGrid, b, seed);
      const double mean = -b.coverage * mean_depth(b) / 4 * std::pow(16. / 15, 2);
      return (s.z.row(j).cast<double>() + s.mean - mean).square().mean();
    };
  };
  for (const Eigen::Index j : {0, 30, 59})
    EXPECT_LE(std::abs(z_value(b.rms * b.rms, row_variance(j))), kZ);
  const TextureDirection texture = texture_direction(brushed_surface({300, 300, 0.1, 0.1}, b, 1));
  EXPECT_NEAR(texture.direction, -0.5, 0.02);
  EXPECT_GE(texture.anisotropy, 0.95);
}

TEST(BrushedSurface, PeriodicOnesContinue) {
  const Brushing b{.rms = 1, .length = 30, .width = 2, .coverage = 5, .spread = 0.02, .orientation = 1.1};
  const HeightField s = brushed_surface({90, 70, 0.1, 0.1}, b, 1, Border::Periodic);
  // Scratches are smooth: no step over the seam is larger than the largest inside it by much.
  const auto largest_step = [&](Eigen::Index from, Eigen::Index to) {
    return (s.z.row(to) - s.z.row(from)).abs().maxCoeff();
  };
  float inside = 0;
  for (Eigen::Index j = 0; j + 1 < 90; ++j)
    inside = std::max(inside, largest_step(j, j + 1));
  EXPECT_LE(largest_step(89, 0), 1.2 * inside);
}

TEST(BrushedSurface, ExtremesAreFiniteOrRefused) {
  for (const Border border : {Border::Open, Border::Periodic}) {
    const HeightField s =
        brushed_surface({5, 4, 0.1, 0.1}, {.rms = 1, .length = 1e3, .width = 0.01, .coverage = 1}, 1, border);
    EXPECT_EQ(missing_count(s), 0);
    EXPECT_EQ(missing_count(brushed_surface({1, 1, 1, 1}, {}, 1, border)), 0);
  }
  EXPECT_THROW(brushed_surface(kGrid, {.width = 0}, 1), InputError);
  EXPECT_THROW(brushed_surface(kGrid, {.coverage = 1e9}, 1), InputError);
  EXPECT_THROW(brushed_surface(kGrid, {.spread = 4}, 1), InputError);
}

TEST(RandomSurfaces, DoNotDependOnTheNumberOfThreads) {
  const auto make = [](Border border) {
    const SyntheticGrid grid{100, 90, 0.1, 0.1};
    return std::vector<HeightField>{gaussian_surface(grid, {1, 2, 0.05, 0.4}, 5, border),
                                    brushed_surface(grid, {.orientation = 0.3}, 5, border),
                                    make_holes(gaussian_surface(grid, {}, 5, border), {0.3, 0.4}, 5)};
  };
  for (const Border border : {Border::Open, Border::Periodic}) {
    set_thread_count(1);
    const auto one = make(border);
    set_thread_count(3);
    const auto three = make(border);
    set_thread_count(0);
    for (std::size_t k = 0; k < one.size(); ++k) {
      EXPECT_TRUE((one[k].z == three[k].z || (one[k].z.isNaN() && three[k].z.isNaN())).all()) << k;
      EXPECT_EQ(one[k].mean, three[k].mean);
    }
  }
}

TEST(Gratings, AreTheirFormulas) {
  const SyntheticGrid grid{40, 50, 0.1, 0.2};
  const Grating g{.period = 1.7, .depth = 0.4, .orientation = 0.6};
  const HeightField sine = sinusoid_surface(grid, g), blazed = blazed_surface(grid, g);
  const HeightField levels = two_level_surface(grid, g, 0.3);
  for (int j = 0; j < 40; ++j)
    for (int i = 0; i < 50; ++i) {
      const double t = (std::cos(0.6) * i * 0.1 + std::sin(0.6) * j * 0.2) / 1.7, phase = std::fmod(t, 1);
      EXPECT_NEAR(height(sine, j, i), 0.2 * std::sin(2 * kPi * t), kFloatRounding);
      EXPECT_NEAR(height(blazed, j, i), 0.4 * phase, kFloatRounding);
      EXPECT_NEAR(height(levels, j, i), phase < 0.3 ? 0.4 : 0, kFloatRounding);
    }
}

TEST(Gratings, EdgesOnGridPointsStayInPlace) {
  // A period of ten points whose edges all fall on points, where rounding could push either way.
  for (const double pitch : {0.1, 0.11, 1. / 3}) {
    const HeightField s = two_level_surface({2, 1000, pitch, pitch}, {.period = 10 * pitch, .depth = 1}, 0.5);
    for (int i = 0; i < 1000; ++i)
      ASSERT_EQ(std::lround(height(s, 0, i)), i % 10 < 5 ? 1 : 0) << pitch << " " << i;
    const HeightField b = blazed_surface({2, 1000, pitch, pitch}, {.period = 10 * pitch, .depth = 1});
    for (int i = 0; i < 1000; ++i)
      ASSERT_NEAR(height(b, 0, i), i % 10 / 10., kFloatRounding);
  }
}

TEST(Gratings, PeriodicOnesMustFit) {
  const SyntheticGrid grid{40, 50, 0.1, 0.1};
  EXPECT_NO_THROW(sinusoid_surface(grid, {.period = 0.5}, Border::Periodic));
  EXPECT_NO_THROW(sinusoid_surface(grid, {.period = 0.4, .orientation = kPi / 2}, Border::Periodic));
  EXPECT_THROW(blazed_surface(grid, {.period = 0.7}, Border::Periodic), InputError);
  EXPECT_THROW(two_level_surface(grid, {.period = 0.5, .orientation = 0.1}, 0.5, Border::Periodic),
               InputError);
  EXPECT_THROW(sinusoid_surface(grid, {.period = 0}), InputError);
  EXPECT_THROW(two_level_surface(grid, {}, 1.5), InputError);
}

TEST(ShapedSurfaces, PlaneStepFacet) {
  const SyntheticGrid grid{21, 31, 0.5, 0.25};
  EXPECT_NEAR(Sdq(plane_surface(grid, 0.3, -0.4)), 0.5, kFloatRounding);
  const HeightField step = step_surface(grid, -2, 0);
  EXPECT_NEAR(height(step, 7, 15), 0, kFloatRounding);
  EXPECT_NEAR(height(step, 7, 16), -2, kFloatRounding);
  const HeightField facet = facet_surface(grid, 2, 0.1, 0.2);
  EXPECT_EQ(facet.z.size() - missing_count(facet), 5 * 9);
  EXPECT_NEAR(Sdq(facet), std::hypot(0.1, 0.2), kFloatRounding);
  EXPECT_THROW(facet_surface(grid, 0.3, 0, 0), InputError);
  EXPECT_EQ(plane_surface({1, 1, 1, 1}, 1, 1).z(0, 0), 0);
}

TEST(Holes, TakeTheirFraction) {
  const HeightField plane = plane_surface({100, 120, 0.1, 0.2}, 0.1, 0);
  for (const double radius : {0., 0.15, 0.7, 5.})
    EXPECT_LE(std::abs(z_value(
                  0.2,
                  [&](std::uint64_t seed) {
                    return static_cast<double>(missing_count(make_holes(plane, {0.2, radius}, seed))) / 12000;
                  })),
              kZ)
        << radius;
  EXPECT_EQ(missing_count(make_holes(plane, {1, 0}, 1)), 12000);
  EXPECT_EQ(missing_count(make_holes(plane, {0, 1}, 1)), 0);
  EXPECT_THROW(make_holes(plane, {1.1, 0}, 1), InputError);
  EXPECT_THROW(make_holes(plane, {0.1, 0.01}, 1), InputError);
  EXPECT_THROW(make_holes(plane, {0.1, -1}, 1), InputError);
  const HeightField holed = make_holes(plane, {0.5, 0.5}, 3);
  for (Eigen::Index k = 0; k < plane.z.size(); ++k)
    if (!is_missing(holed.z(k))) {
      ASSERT_NEAR(holed.z(k) + holed.mean, plane.z(k) + plane.mean, kFloatRounding);
    }
}

}  // namespace
}  // namespace micro
