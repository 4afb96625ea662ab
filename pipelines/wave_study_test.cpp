#include "pipelines/wave_study.h"

#include <gtest/gtest.h>

#include "kirchhoff/kirchhoff.h"
#include "testing/kirchhoff_ensemble.h"

namespace micro {
namespace {

// The Hankel transform against the series, which shares nothing with it.
TEST(WaveStudy, MeanDensityIsThatOfTheSeries) {
  for (const double rms : {0.02, 0.3})
    for (const double sin_theta : {0.0, 0.05, 0.2, 0.4}) {
      const Vec3 q = wave_vector({sin_theta, 0, std::sqrt(1 - sin_theta * sin_theta)}, 0.555);
      const double series = testing::gaussian_mean_density(q, {rms, 3, 3});
      const double integral = mean_kirchhoff_density({{rms, 3, 3}}, 0.555, sin_theta);
      EXPECT_LE(std::abs(integral - series),
                1e-6 * testing::gaussian_mean_density({0, 0, q.norm()}, {rms, 3, 3}))
          << rms << " " << sin_theta;
    }
}

// [Dong15 §6.2]: one correlation length of 3 µm keeps the waves at α = 0.200 where the filter makes 0.138;
// with τ ≫ 2σ, and on many scales, they agree.
TEST(WaveStudy, FilteredAndWaveOpticsDifferAsPredicted) {
  const WaveStudyRequest request{.surfaces = 6, .points = 300};
  const auto cases = wave_study_cases();
  for (const WaveStudyCase& surface : {cases[1], cases[3], cases[4]}) {
    const WaveStudyRow row = study_waves(surface, request);
    // Six surfaces know their own error to a third; the pitch and the bins add 1 %.
    EXPECT_LE(std::abs(row.kirchhoff.value - row.kirchhoff_predicted),
              5 * row.kirchhoff.error + 0.01 * row.kirchhoff.value)
        << to_markdown({row});
    EXPECT_LE(std::abs(row.filtered.value - row.filtered_predicted),
              5 * row.filtered.error + 0.01 * row.filtered.value)
        << to_markdown({row});
    EXPECT_LE(row.kirchhoff.error, 0.1 * row.kirchhoff.value);
  }
  const WaveStudyRow one = study_waves(cases[1], {.surfaces = 1, .points = 40});
  EXPECT_NEAR(one.kirchhoff_predicted, 0.200, 0.004);
  EXPECT_NEAR(one.filtered_predicted, 0.138, 0.001);
}

}  // namespace
}  // namespace micro
