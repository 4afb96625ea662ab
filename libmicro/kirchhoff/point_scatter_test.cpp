#include "kirchhoff/point_scatter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <random>

namespace micro {
namespace {

using Complex = std::complex<double>;

constexpr double kPitch = 0.1;
constexpr std::int64_t kBegin = -4, kEndX = 30, kEndY = 25;

std::vector<SurfacePoint> random_points(int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> x(0, 2.5), y(0, 2.0);
  std::vector<SurfacePoint> points;
  for (int n = 0; n < count; ++n)
    points.push_back({x(random), y(random), static_cast<float>(n), 0.5f + static_cast<float>(n % 3)});
  return points;
}

/// What a point's neighbours on the grid sum up to in direction (qx, qy), each divided by its factor.
template <typename Real>
Complex spectrum_of(const PointScatter<Real>& scatter, std::size_t n, double qx, double qy,
                    const std::vector<double>& factor_x) {
  Complex along_x = 0, along_y = 0;
  for (int t = 0; t < scatter.taps; ++t) {
    const auto at = n * static_cast<std::size_t>(scatter.taps) + static_cast<std::size_t>(t);
    const int col = scatter.col[n] + t, row = scatter.row[n] + t;
    const double factor = factor_x.empty() ? 1 : factor_x[static_cast<std::size_t>(col)];
    along_x += std::polar(static_cast<double>(scatter.x[at]) / factor,
                          -qx * kPitch * static_cast<double>(kBegin + col));
    along_y +=
        std::polar(static_cast<double>(scatter.y[at]), -qy * kPitch * static_cast<double>(kBegin + row));
  }
  return along_x * along_y;
}

template <typename Real>
void expect_shifted_spectra(const std::vector<double>& factor_x) {
  constexpr int kWidth = 8;
  constexpr double kTolerance = 3e-5;  // of this width and oversampling
  const GriddingKernel kernel(kWidth, 1.25, kPitch);
  const auto points = random_points(200);
  const auto scatter =
      make_point_scatter<Real>(points, {kernel, kBegin, kEndX, factor_x}, {kernel, kBegin, kEndY});
  ASSERT_EQ(scatter.size(), points.size());
  for (std::size_t n = 0; n < scatter.size(); ++n) {
    const SurfacePoint& point = points[static_cast<std::size_t>(scatter.z[n])];  // its height tells which
    EXPECT_EQ(scatter.weight[n], point.weight);
    EXPECT_GE(scatter.row[n], n > 0 ? scatter.row[n - 1] : 0);
    EXPECT_GE(scatter.col[n], 0);
    EXPECT_LE(scatter.col[n] + scatter.taps, kEndX - kBegin);
    EXPECT_LE(scatter.row[n] + scatter.taps, kEndY - kBegin);
    for (const auto& [qx, qy] : {std::pair(0., 0.), std::pair(3., -20.), std::pair(-15., 7.)}) {
      const double grid = kernel.spectrum(qx) * kernel.spectrum(qy), peak = std::pow(kernel.spectrum(0), 2);
      const Complex wanted = std::polar(grid, -(qx * point.x + qy * point.y));
      ASSERT_LE(std::abs(spectrum_of(scatter, n, qx, qy, factor_x) - wanted), 2 * kTolerance * peak) << n;
    }
  }
}

TEST(PointScatter, ShiftsTheSpectrumOfEachPoint) {
  expect_shifted_spectra<float>({});
  expect_shifted_spectra<double>({});
}

TEST(PointScatter, WeighsGridPointsByTheirFactors) {
  std::vector<double> factor;
  for (std::int64_t m = kBegin; m < kEndX; ++m)
    factor.push_back(1 + 0.1 * std::sin(static_cast<double>(m)));
  expect_shifted_spectra<double>(factor);
}

TEST(PointScatter, OfNoPointsIsEmpty) {
  const GriddingKernel kernel(6, 1.25, kPitch);
  const auto scatter = make_point_scatter<float>({}, {kernel, kBegin, kEndX}, {kernel, kBegin, kEndY});
  EXPECT_EQ(scatter.size(), 0u);
  EXPECT_EQ(scatter.bytes(), 0);
}

}  // namespace
}  // namespace micro
