#include "distribution/ring_convolution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/grid.h"
#include "core/parallel.h"
#include "core/random.h"

namespace micro {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
/// Two interpolations along two axes, each to 2e-5 of the peak.
constexpr double kInterpolation = 8e-5;
/// Mass is kept to the rounding of the sums.
constexpr double kMass = 1e-11;

Vec3 direction(const DiskGrid& grid, Eigen::Index j, Eigen::Index i) {
  return {grid.coordinate(i), grid.coordinate(j), std::sqrt(grid.mz2(j, i))};
}

/// The literal definition: each node's mass over all nodes of the hemisphere, by a Gaussian cut at 1e-6.
Grid<double> literal(const DiskTable& table, double fwhm) {
  const DiskGrid& grid = table.grid;
  Grid<double> sum = Grid<double>::Zero(grid.size, grid.size);
  for (Eigen::Index j = 0; j < grid.size; ++j)
    for (Eigen::Index i = 0; i < grid.size; ++i) {
      if (table.density(j, i) == 0) continue;
      Grid<double> kernel = Grid<double>::Zero(grid.size, grid.size);
      for (Eigen::Index row = 0; row < grid.size; ++row)
        for (Eigen::Index col = 0; col < grid.size; ++col) {
          if (!(grid.mz2(row, col) > 0)) continue;
          const Vec3 u = direction(grid, j, i), v = direction(grid, row, col);
          const double angle = 2 * std::asin(std::min(1., (u - v).norm() / 2));
          const double response = std::exp(-4 * std::numbers::ln2 * std::pow(angle / fwhm, 2));
          kernel(row, col) = response < 1e-6 ? 0 : response;
        }
      sum += table.density(j, i) * kernel / kernel.sum();
    }
  return sum;
}

/// Needles: at the centre, on the axes, on the rim, and at random.
DiskTable needles(const DiskGrid& grid) {
  DiskTable table = make_disk_table(grid);
  const Eigen::Index c = (grid.size - 1) / 2;
  for (const auto& [j, i] :
       {std::pair{c, c}, std::pair{c, c + 1}, std::pair{c - 3, c}, std::pair{c, 2 * c - 1},
        std::pair{Eigen::Index{1}, c}, std::pair{c, Eigen::Index{1}}})
    table.density(j, i) = 1;
  for (std::uint64_t k = 0; k < 30; ++k) {
    const auto [a, b] = random_uniform(7, 0, k);
    const auto j = static_cast<Eigen::Index>(a * grid.size), i = static_cast<Eigen::Index>(b * grid.size);
    if (grid.mz2(j, i) > 0) table.density(j, i) = 1 + a;
  }
  return table;
}

TEST(RingConvolution, EqualsTheLiteralSumAtTheRimToo) {
  for (const double fwhm : {6 * kDegree, 14 * kDegree, 50 * kDegree}) {
    const DiskTable table = needles({129, 1});
    const Signature signature = gaussian_signature(fwhm);
    const auto spacing = ring_spacing(signature);
    ASSERT_TRUE(spacing.has_value());
    const DiskTable seen = convolve_on_rings(table, SignatureKernel(signature), *spacing);
    const Grid<double> expected = literal(table, fwhm);
    EXPECT_LE((seen.density - expected).abs().maxCoeff(), kInterpolation * expected.maxCoeff()) << fwhm;
    EXPECT_NEAR(normalization(seen) / normalization(table), 1, kMass);
    EXPECT_GE(seen.density.minCoeff(), 0);
  }
}

TEST(RingConvolution, AZoomedTableShowsThePartOfTheWhole) {
  const Signature signature = gaussian_signature(12 * kDegree);
  const SignatureKernel kernel(signature);
  const double spacing = ring_spacing(signature).value();
  DiskTable whole = make_disk_table({257, 1}), zoomed = make_disk_table({33, 0.125});
  for (const auto& [j, i] : {std::pair{16, 16}, std::pair{10, 29}, std::pair{0, 3}})
    zoomed.density(j, i) = whole.density(112 + j, 112 + i) = 1;
  const DiskTable part = convolve_on_rings(zoomed, kernel, spacing);
  const Grid<double> expected = convolve_on_rings(whole, kernel, spacing).density.block(112, 112, 33, 33);
  constexpr double kRipples = 1e-6;  // the factor that makes up for ripples is each table's own
  EXPECT_LE((expected - part.density).abs().maxCoeff(), kRipples * expected.maxCoeff());
}

// A lobe of a few hundredths of a degree under a signature of degrees: more nodes in reach than can be
// visited.
TEST(RingConvolution, AFarZoomedTableIsFlatUnderAWideSignature) {
  const DiskGrid grid{65, 1e-3};
  DiskTable table = make_disk_table(grid);
  table.density(32, 32) = 1;
  const double fwhm = 5 * kDegree;
  const Signature signature = gaussian_signature(fwhm);
  const DiskTable seen =
      convolve_on_rings(table, SignatureKernel(signature), ring_spacing(signature).value());
  // Close by, the sphere is flat: ∫ exp(−4 ln2 r²/fwhm²) dA = π fwhm²/(4 ln2), but for O(fwhm²).
  const double expected =
      grid.spacing() * grid.spacing() * 4 * std::numbers::ln2 / (std::numbers::pi * fwhm * fwhm);
  EXPECT_NEAR(seen.density(32, 32) / expected, 1, fwhm * fwhm);
  EXPECT_NEAR(seen.density.minCoeff() / seen.density.maxCoeff(), 1, 1e-3);
}

TEST(RingConvolution, TheSameForAnyNumberOfThreads) {
  const Signature signature = gaussian_signature(8 * kDegree);
  const int threads = thread_count();
  const auto run = [&](int n) {
    set_thread_count(n);
    return convolve_on_rings(needles({129, 1}), SignatureKernel(signature), ring_spacing(signature).value());
  };
  const DiskTable one = run(1), four = run(4);
  set_thread_count(threads);
  EXPECT_TRUE((one.density == four.density).all());
}

TEST(RingConvolution, AKinkIsLeftToTheLiteralSum) {
  EXPECT_FALSE(ring_spacing({{0, 5 * kDegree, 10 * kDegree}, {2, 1, 0}}).has_value());
}

}  // namespace
}  // namespace micro
