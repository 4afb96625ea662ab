#include "kirchhoff/subdivision.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "kirchhoff/kirchhoff.h"
#include "kirchhoff/spectral.h"
#include "testing/cosine_surface.h"
#include "testing/exact_table.h"

namespace micro {
namespace {

constexpr double kLambdaQ = 0.555;

HeightField wavy(double pitch) {
  HeightField surface{Grid<float>(20, 24), pitch, pitch, 0};
  for (Eigen::Index j = 0; j < surface.rows(); ++j)
    for (Eigen::Index i = 0; i < surface.cols(); ++i)
      surface.z(j, i) = static_cast<float>(0.08 * std::sin(0.5 * static_cast<double>(i)) *
                                           std::cos(0.4 * static_cast<double>(j)));
  return surface;
}

DiskGrid to_first_order(double pitch) {
  return {33, std::min(1., kLambdaQ / (2 * pitch))};
}

// A table that ends at the grid's first false order has in-plane phases of half a turn a cell, however coarse
// the grid: what is left to resolve are the heights.
TEST(Subdivision, DoesNotGrowWithThePitchWhereTheTableEndsAtTheFirstFalseOrder) {
  for (const double pitch : {1., 10., 1000., 1e6}) {
    const SpectralChoice choice = choose_spectral(wavy(pitch), to_first_order(pitch), kLambdaQ, 1e-3);
    EXPECT_LE(choice.subdivision, 8) << pitch << " µm";
  }
}

TEST(Subdivision, CoarseGridsAreRightToTolerance) {
  constexpr double kTol = 1e-3;
  for (const double pitch : {1., 1000.}) {
    const HeightField surface = wavy(pitch);
    const DiskGrid grid = to_first_order(pitch);
    const KirchhoffTable table = spectral_table(surface, grid, kLambdaQ, kTol);
    EXPECT_TRUE(table.reached);
    const auto error =
        testing::table_error(table.table.density, testing::exact_table(surface, grid, kLambdaQ), 0);
    EXPECT_LE(error.relative_l2, kTol) << pitch << " µm";
    EXPECT_LE(error.median, 30 * kTol) << pitch << " µm";
  }
}

// A few cliffs do not make the lattice finer: they are integrated one by one.
TEST(Subdivision, LeavesCliffsOut) {
  const double phase = 4 * std::numbers::pi / kLambdaQ * 0.11;
  HeightField surface = testing::make_gaussian_surface({}, 3);
  const Subdivision smooth = choose_subdivision(surface, {phase, 1, 1e-3});
  surface.z.rightCols(20) += 10;
  const Subdivision stepped = choose_subdivision(surface, {phase, 1, 1e-3});
  EXPECT_LE(stepped.n, smooth.n);
  EXPECT_LT(stepped.steepest, 10 / 0.11);
  const KirchhoffTable table = spectral_table(surface, {33, 1}, kLambdaQ, 1e-3);
  EXPECT_TRUE(table.reached);
  EXPECT_GT(table.work.steep_points, 0);
}

// Whole disk: √(1 + s²)·|q|·d ≤ 2π·n for all facets that the lattice keeps.
TEST(Subdivision, KeepsTheFacetsOfAWholeDiskFromAliasing) {
  HeightField ramp{Grid<float>(30, 30), 0.4, 0.4, 0};
  for (Eigen::Index j = 0; j < ramp.rows(); ++j)
    for (Eigen::Index i = 0; i < ramp.cols(); ++i)
      ramp.z(j, i) = static_cast<float>(2 * 0.4 * static_cast<double>(i));
  const double phase = 4 * std::numbers::pi / kLambdaQ * 0.4;
  const Subdivision chosen = choose_subdivision(ramp, {phase, 1, 1e-3});
  EXPECT_GE(2 * std::numbers::pi * chosen.n,
            phase * std::sqrt(1 + chosen.steepest * chosen.steepest) * (1 - 1e-12));
  EXPECT_GT(chosen.steepest, 2) << "where everything is steep, the lattice is cheaper";
}

}  // namespace
}  // namespace micro
