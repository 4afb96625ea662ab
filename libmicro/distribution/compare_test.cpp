#include "distribution/compare.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"

namespace micro {
namespace {

/// A Gaussian lobe in m_xy; `shift` in m_x.
DiskTable lobe(double sx, double sy, double shift = 0) {
  DiskTable table = make_disk_table({401, 0.5});
  for (int j = 0; j < 401; ++j)
    for (int i = 0; i < 401; ++i) {
      const double x = (table.grid.coordinate(i) - shift) / sx, y = table.grid.coordinate(j) / sy;
      table.density(j, i) = std::exp(-(x * x + y * y) / 2);
    }
  table.density /= normalization(table);
  return table;
}

constexpr double kBins = 1e-4;  // the quantiles are linear within a bin

TEST(Compare, WidthOfAGaussianIsItsQuartile) {
  const LobeWidth width = lobe_width(lobe(0.03, 0.08));
  EXPECT_NEAR(width.x, 0.6745 * 0.03, kBins);
  EXPECT_NEAR(width.y, 0.6745 * 0.08, kBins);
  const LobeWidth shifted = lobe_width(lobe(0.03, 0.08, 0.1));
  EXPECT_NEAR(shifted.x, width.x, kBins);
}

TEST(Compare, TotalVariationOfShiftedGaussians) {
  EXPECT_EQ(total_variation(lobe(0.05, 0.05), lobe(0.05, 0.05)), 0);
  // Two unit Gaussians d apart: 2Φ(d/2) − 1 = erf(d/(2√2)).
  EXPECT_NEAR(total_variation(lobe(0.05, 0.05), lobe(0.05, 0.05, 0.05)), std::erf(1 / (2 * std::sqrt(2.))),
              1e-3);
}

TEST(Compare, RefusesTablesOnDifferentGrids) {
  EXPECT_THROW(total_variation(make_disk_table({9, 1}), make_disk_table({9, 0.5})), InputError);
}

TEST(Compare, AnEmptyTableHasNoWidth) {
  EXPECT_TRUE(std::isnan(lobe_width(make_disk_table({9, 1})).x));
}

}  // namespace
}  // namespace micro
