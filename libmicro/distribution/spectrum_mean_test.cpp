#include "distribution/spectrum_mean.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/random.h"
#include "distribution/table_mean.h"

namespace micro {
namespace {

constexpr int kScans = 7;
constexpr DiskGrid kSmall = {17, 1};

/// One scan's tables at two wavelengths: about ½ and 1000½.
std::vector<Grid<float>> tables_of(int scan) {
  std::vector<Grid<float>> tables;
  for (int k = 0; k < 2; ++k) {
    Grid<double> density = make_disk_table(kSmall).density;
    for (Eigen::Index n = 0; n < density.size(); ++n)
      if (kSmall.mz2(n / 17, n % 17) > 0)
        density.data()[n] = 1000 * k + random_uniform(scan, k, static_cast<std::uint64_t>(n))[0];
    tables.emplace_back(density.cast<float>());
  }
  return tables;
}
double weight_of(int scan) {
  return 100 + 30 * scan;
}

/// Against the same sums in double; a mean's rounding is relative to 1000.
void expect_means_of_all(const SpectrumMean& spectrum) {
  TableMean first(kSmall), second(kSmall);
  for (int scan = 0; scan < kScans; ++scan) {
    const std::vector<Grid<float>> tables = tables_of(scan);
    first.add({kSmall, tables[0].cast<double>()}, weight_of(scan));
    second.add({kSmall, tables[1].cast<double>()}, weight_of(scan));
  }
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

TEST(SpectrumMean, EqualsTheMeanOfEachTable) {
  SpectrumMean spectrum(kSmall, 2);
  for (int scan = 0; scan < kScans; ++scan) {
    spectrum.add(tables_of(scan), weight_of(scan));
    EXPECT_EQ(spectrum.standard_error(0).has_value(), scan > 0);
  }
  spectrum.add({Grid<float>::Zero(17, 17), Grid<float>::Zero(17, 17)}, 0);  // no surface
  expect_means_of_all(spectrum);
}

TEST(SpectrumMean, PartsAddUp) {
  for (const auto& sizes :
       {std::vector{1, 6}, std::vector{6, 1}, std::vector{0, 3, 0, 1, 3}, std::vector{1, 1, 5}}) {
    SpectrumMean all(kSmall, 2);
    int scan = 0;
    for (const int size : sizes) {
      SpectrumMean part(kSmall, 2);
      for (int k = 0; k < size; ++k, ++scan)
        part.add(tables_of(scan), weight_of(scan));
      all.merge(part);
    }
    expect_means_of_all(all);
  }
  EXPECT_THROW(SpectrumMean(kSmall, 2).merge(SpectrumMean(kSmall, 3)), InputError);
  EXPECT_THROW(SpectrumMean(kSmall, 2).merge(SpectrumMean({19, 1}, 2)), InputError);
}

TEST(SpectrumMean, AgreeingScansHaveNoError) {
  SpectrumMean mean({5, 1}, 1);
  for (const double weight : {1., 3., 7.})
    mean.add({Grid<float>::Constant(5, 5, 0.1F)}, weight);
  EXPECT_LE(mean.standard_error(0)->maxCoeff(), 1e-9);
}

}  // namespace
}  // namespace micro
