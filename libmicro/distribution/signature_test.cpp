#include "distribution/signature.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/random.h"

namespace micro {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
/// Mass is kept to the rounding of the sums.
constexpr double kMass = 1e-12;
/// Interpolation of the response between its samples, and the cut at 1e-6.
constexpr double kResponse = 1e-4;

DiskTable needle(const DiskGrid& grid, Eigen::Index j, Eigen::Index i) {
  DiskTable table = make_disk_table(grid);
  table.density(j, i) = 1 / (grid.spacing() * grid.spacing());
  return table;
}

double angle_between(const DiskGrid& grid, Eigen::Index j, Eigen::Index i, Eigen::Index row,
                     Eigen::Index col) {
  const auto direction = [&](Eigen::Index a, Eigen::Index b) {
    return Vec3(grid.coordinate(b), grid.coordinate(a), std::sqrt(grid.mz2(a, b)));
  };
  const Vec3 u = direction(j, i), v = direction(row, col);
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

TEST(Signature, ANeedleTakesTheSignaturesShape) {
  const DiskGrid grid{257, 1};
  const double fwhm = 8 * kDegree;
  for (const auto& [row, col] : {std::pair{128, 128}, std::pair{128, 200}, std::pair{60, 70}}) {
    const DiskTable seen = convolve(needle(grid, row, col), gaussian_signature(fwhm));
    EXPECT_NEAR(normalization(seen), 1, kMass);
    const double peak = seen.density(row, col);
    for (const int step : {1, 3, 5, 8}) {
      const double angle = angle_between(grid, row, col, row + step, col + step / 2);
      const double expected = std::exp(-4 * std::numbers::ln2 * angle * angle / (fwhm * fwhm));
      EXPECT_NEAR(seen.density(row + step, col + step / 2) / peak, expected, kResponse);
    }
  }
}

// The literal definition: every node's mass over all nodes of the hemisphere.
TEST(Signature, EqualsTheLiteralSum) {
  const DiskGrid grid{41, 1};
  DiskTable table = make_disk_table(grid);
  for (int k = 0; k < table.density.size(); ++k)
    if (k % 3) table.density.data()[k] = random_uniform(1, 0, static_cast<std::uint64_t>(k))[0];
  for (int j = 0; j < 41; ++j)
    for (int i = 0; i < 41; ++i)
      if (!(grid.mz2(j, i) > 0)) table.density(j, i) = 0;
  const double fwhm = 15 * kDegree;
  Grid<double> literal = Grid<double>::Zero(41, 41);
  for (int j = 0; j < 41; ++j)
    for (int i = 0; i < 41; ++i) {
      if (table.density(j, i) == 0) continue;
      Grid<double> kernel = Grid<double>::Zero(41, 41);
      for (int row = 0; row < 41; ++row)
        for (int col = 0; col < 41; ++col)
          if (grid.mz2(row, col) > 0)
            kernel(row, col) =
                std::exp(-4 * std::numbers::ln2 * std::pow(angle_between(grid, j, i, row, col) / fwhm, 2));
      literal += table.density(j, i) * kernel / kernel.sum();
    }
  const DiskTable seen = convolve(table, gaussian_signature(fwhm));
  EXPECT_LE((seen.density - literal).abs().maxCoeff(), kResponse * literal.maxCoeff());
}

TEST(Signature, KeepsTheMassAtTheRim) {
  const DiskGrid grid{129, 1};
  for (const auto& [row, col] : {std::pair{64, 127}, std::pair{64, 1}, std::pair{20, 20}, std::pair{64, 64}})
    EXPECT_NEAR(normalization(convolve(needle(grid, row, col), gaussian_signature(5 * kDegree))), 1, kMass);
}

// What a table shows does not depend on how far out it goes: these nodes coincide with the whole table's.
TEST(Signature, AZoomedTableLosesWhatLeavesIt) {
  const DiskTable whole = convolve(needle({257, 1}, 128, 128), gaussian_signature(12 * kDegree));
  const DiskTable zoomed = convolve(needle({33, 0.125}, 16, 16), gaussian_signature(12 * kDegree));
  EXPECT_LT(normalization(zoomed), 0.99);
  EXPECT_LE((whole.density.block(112, 112, 33, 33) - zoomed.density).abs().maxCoeff(),
            kResponse * whole.density.maxCoeff());  // one may be summed literally, the other on rings
}

TEST(Signature, NarrowerThanTheSpacingChangesNothing) {
  const DiskTable table = needle({65, 1}, 30, 40);
  const DiskTable seen = convolve(table, gaussian_signature(1e-4));
  EXPECT_LE((seen.density - table.density).abs().maxCoeff(), kMass * table.density.maxCoeff());
}

TEST(Signature, AMeasuredKernelIsUsedAsItStands) {
  const Signature measured{{0, 5 * kDegree, 10 * kDegree}, {2, 1, 0}};
  const DiskGrid grid{129, 1};
  const DiskTable seen = convolve(needle(grid, 64, 64), measured);
  EXPECT_NEAR(normalization(seen), 1, kMass);
  const double angle = angle_between(grid, 64, 64, 64, 68);
  EXPECT_NEAR(seen.density(64, 68) / seen.density(64, 64), 1 - angle / (10 * kDegree), kResponse);
  EXPECT_EQ(seen.density(64, 64 + 12), 0);
}

TEST(Signature, RefusesWhatIsNone) {
  EXPECT_THROW(gaussian_signature(0), InputError);
  EXPECT_THROW(gaussian_signature(std::nan("")), InputError);
  EXPECT_THROW(gaussian_signature(4), InputError);
  EXPECT_THROW(require_valid({{0}, {1}}), InputError);
  EXPECT_THROW(require_valid({{0, 1, 1}, {1, 1, 1}}), InputError);
  EXPECT_THROW(require_valid({{0.1, 1}, {1, 1}}), InputError);
  EXPECT_THROW(require_valid({{0, 1}, {0, 1}}), InputError);
  EXPECT_THROW(require_valid({{0, 1}, {1, -1}}), InputError);
  EXPECT_THROW(require_valid({{0, 1}, {1, std::nan("")}}), InputError);
}

}  // namespace
}  // namespace micro
