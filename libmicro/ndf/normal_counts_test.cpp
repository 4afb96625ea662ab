#include "ndf/normal_counts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/random.h"
#include "height/triangles.h"

namespace micro {
namespace {

HeightField plane(int rows, int cols, double zx, double zy) {
  Grid<double> z(rows, cols);
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < cols; ++i)
      z(j, i) = zx * i * 0.5 + zy * j * 0.25;
  return make_height_field(z, 0.5, 0.25);
}

TEST(NormalCounts, APlaneFillsOneBinWithAllTheMass) {
  const HeightField surface = plane(12, 15, 0.3, -0.2);
  const DiskGrid grid{101, 1};
  for (const NormalCounts& counts :
       {naive_counts(surface, grid), filtered_counts(local_planes(surface, 0.5), grid)}) {
    const DiskTable table = density(counts);
    EXPECT_NEAR(normalization(table), 1, 1e-14);
    const double norm = std::sqrt(1 + 0.09 + 0.04);
    const auto i = std::lrint(50 - 0.3 / norm * 50), j = std::lrint(50 + 0.2 / norm * 50);
    EXPECT_NEAR(table.density(j, i), 50. * 50., 1e-9);
  }
}

TEST(NormalCounts, NaiveCountsEveryTriangleOnce) {
  Grid<double> z(30, 40);
  for (int k = 0; k < z.size(); ++k) {
    const auto index = static_cast<std::uint64_t>(k);
    z.data()[k] = random_uniform(1, 1, index)[0] < 0.1 ? kMissing : random_normal(1, 0, index)[0];
  }
  const HeightField surface = make_height_field(z, 0.1, 0.1);
  const NormalCounts counts = naive_counts(surface, {65, 1});
  EXPECT_EQ(counts.total, triangle_count(surface));
  EXPECT_EQ(counts.outside, 0);
  EXPECT_NEAR(normalization(density(counts)), 1, 1e-12);
}

TEST(NormalCounts, FewAndManyAreCountedAlike) {
  // Beside a literal count: 450 normals are written down and sorted on 1025², and counted in a table on 33².
  const HeightField surface = make_height_field(Grid<double>::Random(16, 16), 5, 5);
  for (const int size : {33, 1025}) {
    SCOPED_TRACE(size);
    const DiskGrid grid{size, 1};
    std::map<std::int32_t, std::uint32_t> literal;
    for (Eigen::Index j = 0; j + 1 < surface.rows(); ++j)
      for_each_triangle(surface, j, [&](const Triangle& triangle) {
        const double scale = grid.centre() / std::hypot(1., triangle.zx, triangle.zy);
        const auto i = static_cast<std::int32_t>(std::lrint(grid.centre() - triangle.zx * scale)),
                   row = static_cast<std::int32_t>(std::lrint(grid.centre() - triangle.zy * scale));
        ++literal[row * size + i];
      });
    const NormalCounts counts = naive_counts(surface, grid);
    ASSERT_EQ(counts.nodes.size(), literal.size());
    std::size_t n = 0;
    for (const auto& [node, count] : literal) {
      EXPECT_EQ(counts.nodes[n], node);
      EXPECT_EQ(counts.counts[n++], count);
    }
    const Grid<double> all = density(counts).density;
    EXPECT_EQ((all != 0).count(), static_cast<Eigen::Index>(literal.size()));
    EXPECT_EQ(all.data()[counts.nodes[3]], sparse_density(counts).density[3]);
  }
}

TEST(NormalCounts, NothingLiesOutsideTheDisk) {
  Grid<double> z(60, 60);
  for (int k = 0; k < z.size(); ++k)
    z.data()[k] = 1e3 * random_normal(2, 0, static_cast<std::uint64_t>(k))[0];
  const DiskTable table = density(naive_counts(make_height_field(z, 0.1, 0.1), {33, 1}));
  for (int j = 0; j < 33; ++j)
    for (int i = 0; i < 33; ++i)
      if (!(table.grid.mz2(j, i) > 0)) {
        EXPECT_EQ(table.density(j, i), 0);
      }
  EXPECT_NEAR(normalization(table), 1, 1e-12);
}

TEST(NormalCounts, BeyondTheExtentIsCountedAsOutside) {
  const NormalCounts counts = naive_counts(plane(4, 4, 0.3, 0), {33, 0.1});
  EXPECT_EQ(counts.outside, counts.total);
  EXPECT_EQ(normalization(density(counts)), 0);
}

TEST(NormalCounts, TheSameBinWhateverTheExtent) {
  const HeightField surface = plane(4, 4, 0.05, 0.02);
  const DiskTable wide = density(naive_counts(surface, {101, 1})),
                  narrow = density(naive_counts(surface, {101, 0.1}));
  EXPECT_NEAR(narrow.density.maxCoeff() / wide.density.maxCoeff(), 100, 1e-9);
}

TEST(NormalCounts, NoPointsNoDensity) {
  const HeightField surface = make_height_field(Grid<double>::Constant(5, 5, kMissing), 1, 1);
  EXPECT_EQ(naive_counts(surface, {33, 1}).total, 0);
  EXPECT_EQ(density(naive_counts(surface, {33, 1})).density.maxCoeff(), 0);
}

}  // namespace
}  // namespace micro
