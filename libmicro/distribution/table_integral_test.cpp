#include "distribution/table_integral.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"

namespace micro {
namespace {

/// Speckle: neighbours have nothing to do with one another, a third of the nodes is dark.
Tabulated speckle(const DiskGrid& grid) {
  DiskTable table = make_disk_table(grid);
  for (Eigen::Index j = 0; j < grid.size; ++j)
    for (Eigen::Index i = 0; i < grid.size; ++i) {
      const double value = random_uniform(9, 0, static_cast<std::uint64_t>(j * grid.size + i))[0];
      if (grid.mz2(j, i) > 0) table.density(j, i) = std::max(0., 1.5 * value - 0.5);
    }
  return Tabulated(table);
}

/// What albedos ask for: light at 80 degrees, a horizon where it ends in a jump, 1/m_z towards the rim.
double grazing_light(const Vec3& m) {
  const Vec3 u(std::sin(1.4), 0, std::cos(1.4));
  const double cosine = u.dot(m), out = 2 * cosine * m.z() - u.z();
  return cosine > 0 && out > 0 ? cosine / m.z() : 0;
}

/// Σ over parts × parts points in each cell, D asked at every one.
template <typename G>
double literal_sum(const Tabulated& table, const G& g, int parts) {
  const DiskGrid& grid = table.table().grid;
  const double step = grid.spacing() / parts;
  double sum = 0;
  for (int j = 0; j < (grid.size - 1) * parts; ++j)
    for (int i = 0; i < (grid.size - 1) * parts; ++i) {
      const double x = -grid.extent + (i + 0.5) * step, y = -grid.extent + (j + 0.5) * step;
      if (!(x * x + y * y < 1)) continue;
      const Vec3 m(x, y, std::sqrt(1 - x * x - y * y));
      if (const double density = table.D(m); density > 0) sum += density * g(m);
    }
  return sum * step * step;
}

TEST(TableIntegrals, AreExactWhereTheFunctionIsStraight) {
  constexpr double kRounding = 1e-13, kTolerance = 1e-6;
  for (const DiskGrid& grid : {DiskGrid{101, 0.7}, DiskGrid{33, 1}, DiskGrid{3, 0.5}}) {
    const Tabulated table = speckle(grid);
    const Estimate<double> one = TableIntegral(table)([](const Vec3&) { return 1.; }, kTolerance);
    EXPECT_NEAR(one.value, table.mass(), kRounding);
    EXPECT_LE(one.error, kTolerance);
    const auto straight = [](const Vec3& m) { return 3 * m.x() - 2 * m.y() + 1; };
    const Estimate<double> found = TableIntegral(table)(straight, kTolerance);
    constexpr double kOfTheSum = 1e-4;  // 32 points across a cell of 0.25: moments to (0.25/32)²
    EXPECT_NEAR(found.value, literal_sum(table, straight, 32), kOfTheSum);
    EXPECT_LE(found.error, kTolerance);
  }
}

TEST(TableIntegrals, KeepTheirToleranceAtEveryOne) {
  const TableIntegral integral(speckle({65, 1}));
  const auto bent = [](const Vec3& m) { return std::exp(2 * m.x()) * std::cos(9 * m.y()); };
  for (const auto& g :
       {std::function<double(const Vec3&)>(bent), std::function<double(const Vec3&)>(grazing_light)}) {
    const double reference = integral(g, 1e-4).value;
    std::int64_t before = 0;
    for (const double tolerance : {1e-2, 3e-3, 1e-3}) {
      const Estimate<double> found = integral(g, tolerance);
      EXPECT_LE(found.error, tolerance);
      EXPECT_LE(std::abs(found.value - reference), tolerance);
      EXPECT_GE(found.cost.evaluations, before);
      before = found.cost.evaluations;
    }
  }
}

TEST(TableIntegrals, EqualLiteralSums) {
  const Tabulated table = speckle({65, 1});
  constexpr double kOfTheSum = 3e-4;  // the tolerance over the sum, and 24 points across a cell
  EXPECT_NEAR(TableIntegral(table)(grazing_light, 1e-4).value / literal_sum(table, grazing_light, 24), 1,
              kOfTheSum);
}

TEST(TableIntegrals, SayWhatTheyReached) {
  DiskTable one = make_disk_table({1025, 1});
  one.density(700, 800) = 1e6;
  const TableIntegral integral{Tabulated(one)};
  const Vec3 m(one.grid.coordinate(800), one.grid.coordinate(700), 0);
  const Estimate<double> needle = integral([](const Vec3& at) { return at.x() * at.y(); }, 1e-12);
  EXPECT_NEAR(needle.value, integral([](const Vec3&) { return 1.; }, 1).value * m.x() * m.y(), 1e-9);

  const Estimate<double> impossible = TableIntegral(speckle({65, 1}))(grazing_light, 1e-9);
  EXPECT_GT(impossible.error, 1e-9);
  EXPECT_LE(impossible.cost.evaluations, 4'000'100);
  const Estimate<double> nothing = integral([](const Vec3&) { return NAN; }, 1e-3);
  EXPECT_TRUE(std::isnan(nothing.value));
  EXPECT_FALSE(nothing.error <= 1e-3);
}

}  // namespace
}  // namespace micro
