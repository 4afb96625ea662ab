#include "testing/kirchhoff_ensemble.h"

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <vector>

#include "kirchhoff/exact.h"

namespace micro::testing {
namespace {

Vec3 wave(double hx, double hy, double lambda_q) {
  return wave_vector({hx, hy, std::sqrt(1 - hx * hx - hy * hy)}, lambda_q);
}

// The literal series from m = 1 in 50 digits.
TEST(KirchhoffEnsemble, SeriesIsStableForSmallAndLargeG) {
  using Real = boost::multiprecision::cpp_bin_float_50;
  constexpr double kTolerance = 1e-9;
  for (const double g : {1e-6, 0.01, 1.0, 30.0, 1e3, 1e4})
    for (const double hx : {0.0, 0.1, 0.5, 0.95}) {
      const Vec3 q = wave(hx, 0, 0.5);
      const GaussianStatistics s{std::sqrt(g) / q.z(), 0.4, 0.7};
      const Real b = Real(q.x() * q.x()) * s.tau_x * s.tau_x / 4,
                 gg = Real(q.z() * q.z()) * s.sigma * s.sigma;
      Real sum = 0, weight = exp(-gg);  // g^m e^−g/m!
      for (int m = 1; m < 3 * g + 60; ++m) {
        weight *= gg / m;
        sum += weight / m * exp(-b / m);
      }
      const Real factor = Real(q.squaredNorm()) * q.squaredNorm() / (q.z() * q.z()) * s.tau_x * s.tau_y /
                          (4 * boost::math::constants::pi<Real>());
      const auto expected = static_cast<double>(factor * sum);
      EXPECT_NEAR(gaussian_mean_density(q, s) / expected, 1, kTolerance) << "g = " << g << ", h_x = " << hx;
    }
}

TEST(KirchhoffEnsemble, LargeGIsBeckmannWithTheUnfilteredSlopes) {
  const GaussianStatistics s{30, 300, 200};
  const Vec2 alpha = slope_alpha(s);
  for (const double hx : {0.0, 0.1, 0.2})
    for (const double hy : {0.0, 0.15}) {
      const Vec3 q = wave(hx, hy, 0.5);
      const double g = std::pow(q.z() * s.sigma, 2);
      // The next order in 1/g: 1/m and e^{−b/m} averaged over the Poisson distribution.
      EXPECT_NEAR(gaussian_mean_density(q, s) / beckmann_density(q.normalized(), alpha.x(), alpha.y()), 1,
                  30 / g);
    }
}

// A patch of many correlation lengths: the series and the coherent sinc², up to the share of Δ lost at
// borders.
TEST(KirchhoffEnsemble, PatchTendsToSeriesPlusCoherentPart) {
  const GaussianStatistics s{0.05, 0.6, 0.9};
  const double length = 24;
  for (const double hx : {0.0, 0.02, 0.15, 0.3}) {
    const Vec3 q = wave(hx, 0.05 * hx, 0.555);
    const double patch = gaussian_patch_density(q, s, length, length);
    const double series = gaussian_mean_density(q, s) + gaussian_coherent_density(q, s, length, length);
    EXPECT_NEAR(patch / series, 1, 0.05) << hx;
    const double longer = gaussian_patch_density(q, s, 2 * length, 2 * length);
    const double series2 =
        gaussian_mean_density(q, s) + gaussian_coherent_density(q, s, 2 * length, 2 * length);
    EXPECT_LE(std::abs(longer / series2 - 1), std::max(0.75 * std::abs(patch / series - 1), 1e-4)) << hx;
  }
}

struct EnsembleCase {
  const char* name;
  GaussianStatistics statistics;
};

class GaussianEnsemble : public ::testing::TestWithParam<EnsembleCase> {};

// ⟨D_K⟩ of the triangulated surfaces against the smooth ones' closed form. Piecewise linear heights have
// a variance lower by up to pitch²/2τ² = 0.3 % between nodes (pitch = τ/12) and slopes lower by the same:
// less than a tenth of the statistical error.
TEST_P(GaussianEnsemble, MeanOfExactIsTheClosedForm) {
  constexpr int kSurfaces = 200, kCells = 72;
  const GaussianStatistics& s = GetParam().statistics;
  const double dx = s.tau_x / 12, dy = s.tau_y / 12;
  std::vector<Vec3> q;
  for (const double hx : {0.0, 0.12, 0.3})
    for (const double hy : {0.0, -0.1, 0.25})
      q.push_back(wave(hx, hy, 0.555));
  std::vector<double> sum(q.size()), sum2(q.size());
  for (int k = 0; k < kSurfaces; ++k) {
    HeightField surface =
        gaussian_surface(kCells + 1, kCells + 1, dx, dy, s, static_cast<std::uint64_t>(k + 1));
    const auto field = exact_field(surface, q);
    for (std::size_t d = 0; d < q.size(); ++d) {
      const double density = kirchhoff_density(field[d], kirchhoff_area(surface));
      sum[d] += density;
      sum2[d] += density * density;
    }
  }
  double chi2 = 0;
  for (std::size_t d = 0; d < q.size(); ++d) {
    const double mean = sum[d] / kSurfaces;
    const double error = std::sqrt((sum2[d] / kSurfaces - mean * mean) / (kSurfaces - 1));
    const double expected = gaussian_patch_density(q[d], s, kCells * dx, kCells * dy);
    const double z = (mean - expected) / error;
    EXPECT_LE(std::abs(z), 4.5) << "direction " << d << ": " << mean << " against " << expected;  // 7e-6 each
    chi2 += z * z;
  }
  EXPECT_LT(chi2, 39);  // nine degrees of freedom: 1e-5
}

INSTANTIATE_TEST_SUITE_P(Surfaces, GaussianEnsemble,
                         ::testing::Values(EnsembleCase{"Smooth", {0.03, 1, 1}},
                                           EnsembleCase{"Rough", {0.15, 1, 1}},
                                           EnsembleCase{"Brushed", {0.08, 0.5, 2}},
                                           EnsembleCase{"BrushedAndRough", {0.25, 1, 3}}),
                         [](const auto& test) { return std::string(test.param.name); });

// Predicted: D_K sees the surface's own slopes, the filtered D_M those left after smoothing by s.
TEST(KirchhoffEnsemble, KirchhoffAndFilteredAgreeForLongCorrelationAlone) {
  const double s = 1;
  const GaussianStatistics metal{0.3, 3, 3}, gentle{3, 60, 60};
  EXPECT_NEAR(slope_alpha(metal).x(), 0.200, 1e-3);
  EXPECT_NEAR(filtered_slope_alpha(metal, s).x(), 0.138, 1e-3);
  EXPECT_NEAR(filtered_slope_alpha(gentle, s).x() / slope_alpha(gentle).x(), 1, 2e-3);
  // The known factor at normal incidence: (α_K/α_M)² = ((τ²+4s²)/τ²)².
  const Vec3 q = wave(0, 0, 0.555);
  const Vec2 alpha = filtered_slope_alpha(metal, s);
  EXPECT_NEAR(beckmann_density({0, 0, 1}, alpha.x(), alpha.y()) / gaussian_mean_density(q, metal),
              std::pow(13.0 / 9.0, 2), 0.06);  // 1/g = 0.02
}

}  // namespace
}  // namespace micro::testing
