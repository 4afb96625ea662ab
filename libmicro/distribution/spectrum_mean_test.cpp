#include "distribution/spectrum_mean.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "distribution/table_mean.h"

namespace micro {
namespace {

TEST(SpectrumMean, EqualsTheMeanOfEachTable) {
  constexpr int kScans = 7;
  const DiskGrid grid = {17, 1};
  SpectrumMean spectrum(grid, 2);
  TableMean first(grid), second(grid);
  for (int scan = 0; scan < kScans; ++scan) {
    std::vector<Grid<float>> tables;
    for (int k = 0; k < 2; ++k) {
      Grid<double> density = make_disk_table(grid).density;
      for (Eigen::Index n = 0; n < density.size(); ++n)
        if (grid.mz2(n / 17, n % 17) > 0)
          density.data()[n] = 1000 * k + random_uniform(scan, k, static_cast<std::uint64_t>(n))[0];
      tables.emplace_back(density.cast<float>());
    }
    const double weight = 100 + 30 * scan;
    spectrum.add(tables, weight);
    first.add({grid, tables[0].cast<double>()}, weight);
    second.add({grid, tables[1].cast<double>()}, weight);
    EXPECT_EQ(spectrum.standard_error(0).has_value(), scan > 0);
  }
  spectrum.add({Grid<float>::Zero(17, 17), Grid<float>::Zero(17, 17)}, 0);  // no surface
  EXPECT_EQ(spectrum.count(), kScans);
  EXPECT_DOUBLE_EQ(spectrum.weight(), first.weight());
  const auto worst = [](const Grid<double>& a, const Grid<double>& b) { return (a - b).abs().maxCoeff(); };
  EXPECT_LE(worst(spectrum.mean(0).density, first.mean().density), 1e-12);
  EXPECT_LE(worst(spectrum.mean(1).density, second.mean().density), 1e-9);
  // Deviations are float sums: 1e-7 each, of about 0.1.
  EXPECT_LE(worst(*spectrum.standard_error(0), *first.standard_error()), 1e-6);
  EXPECT_LE(worst(*spectrum.standard_error(1), *second.standard_error()), 1e-6);
  EXPECT_GT(spectrum.standard_error(1)->maxCoeff(), 0.01);
}

TEST(SpectrumMean, AgreeingScansHaveNoError) {
  SpectrumMean mean({5, 1}, 1);
  for (const double weight : {1., 3., 7.})
    mean.add({Grid<float>::Constant(5, 5, 0.1F)}, weight);
  EXPECT_LE(mean.standard_error(0)->maxCoeff(), 1e-9);
}

}  // namespace
}  // namespace micro
