#include "kirchhoff/gridding.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>

namespace micro {
namespace {

TEST(GriddingKernel, SpectrumAndSlopeBelongToIt) {
  for (const int width : {3, 6, 10}) {
    const GriddingKernel kernel(width, 1.25, 0.1);
    const double w = kernel.half_width();
    constexpr int kSteps = 20000;
    for (const double q : {0.0, 5.0, 25.0}) {
      double sum = 0;  // midpoint rule
      for (int s = 0; s < kSteps; ++s) {
        const double x = w * (2 * (s + 0.5) / kSteps - 1);
        sum += kernel(x).k * std::cos(q * x) * 2 * w / kSteps;
      }
      EXPECT_NEAR(kernel.spectrum(q), sum / 0.1, 1e-6 * kernel.spectrum(0));
    }
    for (const double x : {-0.9 * w, -0.2 * w, 0.0, 0.5 * w})
      EXPECT_NEAR(kernel(x).slope, (kernel(x + 1e-6).k - kernel(x - 1e-6).k) / 2e-6, 1e-6 / w);
    EXPECT_EQ(kernel(1.01 * w).k, 0);
  }
}

TEST(GriddingKernelTable, IsTheKernelToNineDigits) {
  for (const int width : {3, 6, 10, 14}) {
    const GriddingKernel kernel(width, 1.25, 0.1);
    const GriddingKernelTable table(kernel);
    double worst = 0, worst_slope = 0;
    for (int s = -12345; s <= 12345; ++s) {
      const double x = kernel.half_width() * s / 12000.5;  // not where the kernel jumps to zero
      worst = std::max(worst, std::abs(table(x).k - kernel(x).k));
      worst_slope = std::max(worst_slope, std::abs(table(x).slope - kernel(x).slope));
    }
    EXPECT_LE(worst, 1e-9) << width;
    EXPECT_LE(worst_slope, 1e-6 / kernel.half_width()) << width;
    EXPECT_EQ(table(0).k, 1) << width;
    EXPECT_EQ(table(-1.001 * kernel.half_width()).k, 0) << width;
  }
}

TEST(GatherAndScatter, ShiftTheSpectrumOfASource) {
  // Σ_m K(mp − x) e^{−iqmp} = K̂(q) e^{−iqx} and with dK/dx, iq times that, up to the error for width and
  // oversampling.
  constexpr int kWidth = 8, kSources = 40;
  constexpr double kPitch = 0.1, kSpacing = 0.043, kTolerance = 3e-5;
  const GriddingKernel kernel(kWidth, 1.25, kPitch);
  const std::int64_t begin = -4, end = 25;
  const auto gather = make_gather<double>(kernel, kSpacing, 1, 2, kSources / 2, begin, end);
  const auto scatter = make_scatter<double>(kernel, kSpacing, kSources, begin, end);
  for (const double q : {0.0, 3.0, -20.0})
    for (const int source : {1, 7, 21, 39}) {
      std::complex<double> gathered, scattered, slope;
      for (std::int64_t m = begin; m < end; ++m) {
        const auto e = std::polar(1.0, -q * kPitch * static_cast<double>(m));
        const auto row = static_cast<std::size_t>(m - begin);
        for (int t = 0; t < gather.taps; ++t)
          if (gather.start[row] + t == source / 2) gathered += gather.value[row * gather.taps + t] * e;
        for (int t = 0; t < scatter.taps; ++t)
          if (scatter.start[source] + begin + t == m) {
            scattered += scatter.value[source * scatter.taps + t] * e;
            slope += scatter.derivative[source * scatter.taps + t] * e;
          }
      }
      const auto want = kernel.spectrum(q) * std::polar(1.0, -q * kSpacing * source);
      const double scale = kTolerance * kernel.spectrum(0);
      EXPECT_LE(std::abs(gathered - want), scale);
      EXPECT_LE(std::abs(scattered - want), scale);
      EXPECT_LE(std::abs(slope - std::complex<double>(0, q) * want), scale * 60);
    }
}

}  // namespace
}  // namespace micro
