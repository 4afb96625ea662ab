#include "distribution/table_mean.h"

#include <gtest/gtest.h>

#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <vector>

#include "core/error.h"
#include "core/random.h"

namespace micro {
namespace {

constexpr DiskGrid kGrid{9, 1};
constexpr double kRounding = 1e-12;

DiskTable constant(double value) {
  DiskTable table = make_disk_table(kGrid);
  table.density.setConstant(value);
  return table;
}

TEST(TableMean, WeighsByArea) {
  TableMean mean(kGrid);
  mean.add(constant(1), 3);
  mean.add(constant(5), 1);
  EXPECT_NEAR(mean.mean().density(4, 4), 2, kRounding);
  EXPECT_EQ(mean.count(), 2);
  EXPECT_DOUBLE_EQ(mean.weight(), 4);
  // √(2/1·(9·1 + 1·9))/4
  EXPECT_NEAR((*mean.standard_error())(4, 4), std::sqrt(2 * (9. + 9.)) / 4, kRounding);
}

TEST(TableMean, EqualWeightsGiveTheTextbookError) {
  TableMean mean(kGrid);
  const std::vector<double> values = {1, 4, 2, 8, 5, 7};
  for (const double value : values)
    mean.add(constant(value), 2.5);
  double m = 0, variance = 0;
  for (const double value : values)
    m += value / 6;
  for (const double value : values)
    variance += (value - m) * (value - m) / 5;
  EXPECT_NEAR((*mean.standard_error())(0, 0), std::sqrt(variance / 6), kRounding);
}

TEST(TableMean, OneScanHasNoError) {
  TableMean mean(kGrid);
  mean.add(constant(1), 1);
  mean.add(constant(7), 0);  // no surface, no say
  EXPECT_FALSE(mean.standard_error().has_value());
  EXPECT_NEAR(mean.mean().density(1, 1), 1, kRounding);
}

TEST(TableMean, ScansThatAgreeHaveErrorZero) {
  TableMean mean(kGrid);
  for (int k = 0; k < 100; ++k)
    mean.add(constant(0.1), 0.3 + k);
  EXPECT_EQ(mean.standard_error()->maxCoeff(), 0);
}

TEST(TableMean, NothingAddedIsZero) {
  EXPECT_EQ(TableMean(kGrid).mean().density.maxCoeff(), 0);
}

TEST(TableMean, RefusesAnotherGrid) {
  TableMean mean(kGrid);
  EXPECT_THROW(mean.add(make_disk_table({9, 0.5}), 1), InputError);
}

// 81 nodes of independent normal numbers with known mean: Σ((D̄ − µ)/SE)² over nodes; with n = 200 the
// t-distribution is normal to within the test's power.
TEST(TableMean, StandardErrorIsCalibrated) {
  TableMean mean(kGrid);
  for (std::uint64_t n = 0; n < 200; ++n) {
    DiskTable table = make_disk_table(kGrid);
    for (std::uint64_t k = 0; k < 81; ++k)
      table.density.data()[k] = 3 + random_normal(5, 0, n * 81 + k)[0];
    mean.add(table, 1 + 0.5 * random_uniform(5, 1, n)[0]);
  }
  const Grid<double> z = (mean.mean().density - 3) / *mean.standard_error();
  const boost::math::chi_squared distribution(81);
  const double p = cdf(distribution, z.square().sum());
  EXPECT_GT(p, 1e-4);
  EXPECT_LT(p, 1 - 1e-4);
}

}  // namespace
}  // namespace micro
