#include "kirchhoff/height_basis.h"

#include <gtest/gtest.h>

#include <cmath>

namespace micro {
namespace {

using Complex = std::complex<double>;

/// (e^{−iqh} − 1)/q by its power series where that converges fast, else as written.
Complex psi(double h, double q) {
  if (std::abs(q * h) > 1e-3) return (std::polar(1.0, -q * h) - 1.0) / q;
  return Complex(-q * h * h / 2, -h + q * q * h * h * h / 6);
}

HeightHistogram even_heights(double low, double high) {
  return {low, high, Eigen::ArrayXd::Constant(512, 1.0 / 512)};
}

/// Largest error over heights and q_z on the nodes of the tables.
double worst_error(const HeightBasis& basis, const HeightHistogram& heights, double origin,
                   const WaveRange& q) {
  constexpr int kHeights = 41, kWaves = 37;
  const auto functions = basis.functions(kHeights, 0, basis.terms());
  const auto coefficients = basis.coefficients(kWaves, 0, basis.terms());
  double worst = 0;
  for (int a = 0; a < kHeights; ++a)
    for (int b = 0; b < kWaves; ++b) {
      const double h = heights.low + (heights.high - heights.low) * a / (kHeights - 1) - origin;
      const double wave = q.low + (q.high - q.low) * b / (kWaves - 1);
      Complex sum = 0;
      for (int k = 0; k < basis.terms(); ++k)
        sum += coefficients(b, k) * functions.value(a, k);
      worst = std::max(worst, std::abs(sum - psi(h, wave)));
    }
  return worst;
}

TEST(HeightBasis, ReproducesPsiWithinTolerance) {
  for (const double reach : {0.001, 0.3, 1.1, 5.0})
    for (const double tolerance : {1e-3, 1e-5}) {
      const HeightHistogram heights = even_heights(-reach, 0.8 * reach);
      const WaveRange q = {0, 22.6};
      const HeightBasis basis(heights, 0.05, q, tolerance / q.high);
      // The promise is on the mean square; at the ends of both ranges the error is largest.
      EXPECT_LE(worst_error(basis, heights, 0.05, q), 25 * tolerance / q.high);
      EXPECT_LE(basis.terms(), 1.8 * reach * q.high / M_PI + 14);
    }
}

TEST(HeightBasis, ChebyshevTakesOverForGreatRanges) {
  const HeightHistogram heights = even_heights(-12, 14);
  const WaveRange q = {3, 22.6};
  const HeightBasis basis(heights, 0.5, q, 1e-6 / q.high);
  EXPECT_GT(basis.terms(), 13 * 22.6);
  EXPECT_LE(worst_error(basis, heights, 0.5, q), 1e-5 / q.high);
}

// A table of small extent: q_z hardly varies, and great heights take few terms all the same.
TEST(HeightBasis, ANarrowRangeOfWavesNeedsFewTerms) {
  for (const double reach : {14.0, 50.0, 400.0})
    for (const double tolerance : {1e-3, 1e-5}) {
      const HeightHistogram heights = even_heights(-reach, 0.9 * reach);
      const WaveRange q = {22.6 - 10 / reach, 22.6};
      const HeightBasis basis(heights, 0.5, q, tolerance / q.high);
      EXPECT_TRUE(basis.orthonormal());
      EXPECT_LE(basis.terms(), 20) << reach;
      EXPECT_NEAR(basis.terms(), expected_basis(heights, q, tolerance).terms, 8) << reach;
      EXPECT_LE(worst_error(basis, heights, 0.5, q), 25 * tolerance / q.high) << reach;
    }
}

TEST(HeightBasis, TwoHeightsNeedFewTerms) {
  HeightHistogram heights{-5, 5, Eigen::ArrayXd::Zero(512)};
  heights.mass[0] = heights.mass[511] = 0.5;
  const HeightBasis two(heights, 0, {0, 22.6}, 1e-1 / 22.6);
  const HeightBasis all(even_heights(-5, 5), 0, {0, 22.6}, 1e-1 / 22.6);
  EXPECT_LT(two.terms(), all.terms());
}

TEST(HeightBasis, SlopesAreDerivatives) {
  const struct {
    double reach;
    WaveRange q;
  } cases[] = {{1, {0, 22.6}}, {30, {22, 22.6}}, {15, {0, 22.6}}};
  for (const auto& [reach, q] : cases) {
    const HeightBasis basis(even_heights(-reach, reach), 0, q, 1e-5);
    const int fine = 2000 * static_cast<int>(reach) + 1;
    const auto f = basis.functions(fine, 0, basis.terms());
    for (const int e : {fine / 50, fine / 3, fine - fine / 50})
      for (int k = 0; k < basis.terms(); ++k)
        EXPECT_NEAR(f.derivative(e, k), (f.value(e + 1, k) - f.value(e - 1, k)) / 2,
                    1e-3 * (f.derivative.col(k).abs().maxCoeff()))
            << reach;
  }
}

TEST(HeightBasis, NothingForAFlatSurface) {
  EXPECT_EQ(HeightBasis({0, 0, Eigen::ArrayXd::Constant(1, 1.0)}, 0, {0, 22.6}, 1e-4).terms(), 0);
}

TEST(HeightHistogram, CountsAndBounds) {
  HeightField surface;
  surface.dx = surface.dy = 1;
  surface.z = Grid<float>::Zero(30, 40);
  surface.z.rightCols(20).setConstant(2);
  surface.z(3, 3) = kMissing;
  const HeightHistogram h = height_histogram(surface);
  EXPECT_EQ(h.low, 0);
  EXPECT_EQ(h.high, 2);
  EXPECT_NEAR(h.mass.sum(), 1, 1e-12);
  EXPECT_NEAR(h.mass[0], 0.5, 0.03);
  surface.z.setConstant(kMissing);
  EXPECT_EQ(height_histogram(surface).mass.sum(), 0);
}

}  // namespace
}  // namespace micro
