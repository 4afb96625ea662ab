#include "pipelines/shadowing_study.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <numbers>

#include "testing/temporary_folder.h"

namespace micro {
namespace {

const std::vector<ShadowingStudyRow>& small_study() {
  static const auto rows = study_shadowing({.nu = {0.1, 1, 2}, .profiles = 16, .length = 512});
  return rows;
}

TEST(ShadowingStudy, SmithOverHeightsIsG1) {
  using Rule = boost::math::quadrature::gauss_kronrod<double, 61>;
  for (const ShadowingStudyRow& row : small_study()) {
    const auto weighted = [&](double eta) {
      return smith_at_height(eta, row.smith_lambda) * std::exp(-eta * eta / 2) /
             std::sqrt(2 * std::numbers::pi);
    };
    // Two routes to Smith's masking of a Gaussian surface, and a third by a table of 1025² nodes.
    EXPECT_NEAR(Rule::integrate(weighted, -9., 9., 10, 1e-10), 1 / (1 + row.smith_lambda), 1e-9);
    const double a = row.simulated.nu / 2;
    EXPECT_NEAR(row.smith_lambda, (std::exp(-a * a) / (a * std::sqrt(std::numbers::pi)) - std::erfc(a)) / 2,
                1e-12);
    EXPECT_NEAR(row.table_g1 * (1 + row.smith_lambda), 1, 2e-3);
  }
}

// What docs/sun.md reports: at the mean height Smith holds where rays are steep, while Sun's form lies above
// all rays and below those that face; averaged over heights and counted by facets Smith is a little high.
TEST(ShadowingStudy, SunIsBetweenAllRaysAndThoseThatFace) {
  for (const ShadowingStudyRow& row : small_study()) {
    if (row.simulated.nu < 1) continue;
    const EscapingPart& simulated = row.simulated.from_mean_height();
    EXPECT_GT(row.sun_closed, simulated.all.value + 4 * simulated.all.error);
    EXPECT_LT(row.sun_closed, simulated.facing.value - 4 * simulated.facing.error);
    EXPECT_NEAR(row.facing * smith_at_height(0, row.smith_lambda), simulated.all.value,
                0.01 + 4 * simulated.all.error);
    EXPECT_LT(row.simulated.from_crossings.value, simulated.all.value);
    // Neither ⟨ΓΓ⟩ nor Γ₀Γ₀ is what the level facets of a mirror's direction do.
    EXPECT_LT(row.sun_closed * row.sun_closed, row.simulated.level_both_ways.value);
  }
}

TEST(ShadowingStudy, LeavesTablesAndFigures) {
  const std::string text = to_markdown(small_study()), csv = to_csv(small_study());
  EXPECT_EQ(std::count(text.begin(), text.end(), '#'), 9);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  EXPECT_EQ(text.find("nan"), std::string::npos);
  // As many columns in the head as in a row.
  const auto line = [&](int n) {
    std::size_t at = 0;
    for (; n > 0; --n)
      at = csv.find('\n', at) + 1;
    return csv.substr(at, csv.find('\n', at) - at);
  };
  const std::string head = line(0), row = line(1);
  EXPECT_EQ(std::count(head.begin(), head.end(), ','), std::count(row.begin(), row.end(), ','));
  const TemporaryFolder folder;
  write_shadowing_figures(small_study(), folder.path());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 6);
}

}  // namespace
}  // namespace micro
