#include "distribution/disk_table.h"

#include <gtest/gtest.h>

#include "core/error.h"

namespace micro {
namespace {

TEST(DiskTable, NodesStandWhereTheConventionSays) {
  const DiskGrid grid{1025, 1};
  EXPECT_DOUBLE_EQ(grid.coordinate(0), -1);
  EXPECT_DOUBLE_EQ(grid.coordinate(512), 0);
  EXPECT_DOUBLE_EQ(grid.coordinate(1024), 1);
  int inside = 0;
  for (int j = 0; j < 1025; ++j)
    for (int i = 0; i < 1025; ++i)
      inside += grid.mz2(j, i) > 0;
  EXPECT_EQ(inside, 823469);
}

// Nodes on the horizon are off the disk whichever way their squares are rounded: by whole numbers there is no
// doubt of it.
TEST(DiskTable, NodesOnTheHorizonAreOffTheDisk) {
  for (const int size : {51, 69, 71, 79, 99, 101, 201, 251, 401, 501, 999, 1001, 1025}) {
    const int c = (size - 1) / 2;
    const DiskGrid grid{size, 1};
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i) {
        const int r2 = (i - c) * (i - c) + (j - c) * (j - c);
        ASSERT_EQ(grid.mz2(j, i) > 0, r2 < c * c) << size << " " << j << " " << i;
      }
  }
}

TEST(DiskTable, ConstantOverPiIsNormalised) {
  DiskTable table = make_disk_table({1025, 1});
  for (int j = 0; j < 1025; ++j)
    for (int i = 0; i < 1025; ++i)
      if (table.grid.mz2(j, i) > 0) table.density(j, i) = 1 / 3.14159265358979;
  EXPECT_NEAR(normalization(table), 1, 1e-4);  // the staircase rim of the disk
}

TEST(DiskTable, ExtentHoldsTheMass) {
  DiskTable table = make_disk_table({101, 0.5});
  table.density(50, 50) = 9;
  table.density(50, 60) = 1;
  EXPECT_NEAR(extent_holding(table, 0.89), 0.5 * 0.01, 1e-12);
  EXPECT_NEAR(extent_holding(table, 0.95), 10.5 * 0.01, 1e-12);
  table.density(0, 50) = 100;
  EXPECT_NEAR(extent_holding(table, 0.95), 0.5, 1e-12);  // never beyond the table
}

TEST(DiskTable, RefusesSizesThatHaveNoCentre) {
  EXPECT_THROW(make_disk_table({1024, 1}), InputError);
  EXPECT_THROW(make_disk_table({1, 1}), InputError);
  EXPECT_THROW(make_disk_table({1025, 0}), InputError);
  EXPECT_THROW(make_disk_table({1025, 1.5}), InputError);
}

TEST(DiskTable, CountsItsNodesOnTheDisk) {
  for (const int size : {3, 5, 17, 65, 129})
    for (const double extent : {0.01, 0.5, 0.7, 0.7072, 0.8, 1.0}) {
      const DiskGrid grid{size, extent};
      std::int64_t nodes = 0;
      for (Eigen::Index j = 0; j < size; ++j)
        for (Eigen::Index i = 0; i < size; ++i)
          nodes += grid.mz2(j, i) > 0;
      EXPECT_EQ(disk_nodes(grid), nodes) << size << " " << extent;
    }
}

}  // namespace
}  // namespace micro
