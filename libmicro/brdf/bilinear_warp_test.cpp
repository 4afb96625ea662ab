#include "brdf/bilinear_warp.h"

#include <gtest/gtest.h>

#include <cmath>

namespace micro {
namespace {

constexpr std::size_t kRows = 3, kCols = 4;
const std::vector<float> kValues = {1, 2, 0, 4, 0, 0, 3, 1, 5, 1, 1, 2};

/// ∫ of the density over [0, x] × rows [0, y] by the midpoint rule.
double mass(const BilinearWarp& warp, double x, double y) {
  constexpr int kSteps = 600;
  double sum = 0;
  for (int j = 0; j < kSteps; ++j)
    for (int i = 0; i < kSteps; ++i)
      sum += warp.density({x * (i + 0.5) / kSteps, y * (j + 0.5) / kSteps});
  return sum * x * y / (kSteps * kSteps);
}

TEST(BilinearWarp, HasMassOne) {
  EXPECT_NEAR(mass(BilinearWarp(kValues, kRows, kCols), 1, 1), 1, 1e-4);
}

// What lies before the sample holds as much as was asked for: of the rows, and along the row at y.
TEST(BilinearWarp, TakesUniformNumbersToTheDensity) {
  const BilinearWarp warp(kValues, kRows, kCols);
  for (const double b : {0.05, 0.4, 0.77})
    for (const double a : {0.1, 0.35, 0.5, 0.93}) {
      const Vec2 at = warp.sample({a, b});
      EXPECT_NEAR(mass(warp, 1, at.y()), b, 1e-4);
      double before = 0, all = 0;
      constexpr int kSteps = 20000;
      for (int i = 0; i < kSteps; ++i) {
        const double x = (i + 0.5) / kSteps, d = warp.density({x, at.y()});
        all += d;
        if (x < at.x()) before += d;
      }
      EXPECT_NEAR(before / all, a, 2e-4);
    }
}

TEST(BilinearWarp, StaysInTheSquareAtItsCorners) {
  const BilinearWarp warp(kValues, kRows, kCols);
  for (const double b : {0., 1.})
    for (const double a : {0., 1.}) {
      const Vec2 at = warp.sample({a, b});
      EXPECT_NEAR(at.y(), b, 1e-9);
      EXPECT_GE(at.x(), 0);
      EXPECT_LE(at.x(), 1);
    }
}

}  // namespace
}  // namespace micro
