#include "kirchhoff/choose.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "core/random.h"
#include "kirchhoff/kirchhoff.h"
#include "testing/gaussian_surface.h"

namespace micro {
namespace {

/// What a 640 × 480 scan of rms 0.3 µm, τ = 3 µm makes.
constexpr KirchhoffSurface kScan{2.0 * 639 * 479, 0.11, 0.11, 0.2, 2.2};

TEST(Choose, MeasuresTheSurface) {
  Grid<double> z(11, 21);
  for (Eigen::Index j = 0; j < z.rows(); ++j)
    for (Eigen::Index i = 0; i < z.cols(); ++i)
      z(j, i) = 0.3 * 0.5 * static_cast<double>(i) + 0.4 * 0.25 * static_cast<double>(j);
  z(0, 0) = NAN;
  const KirchhoffSurface s = kirchhoff_surface(make_height_field(z, 0.5, 0.25));
  EXPECT_EQ(s.triangles, 2 * 10 * 20 - 2);
  EXPECT_NEAR(s.slope, 0.5, 1e-6);
  EXPECT_NEAR(s.height_range, 0.15 * 20 + 0.1 * 10 - 0.1, 1e-6);
  EXPECT_THROW(kirchhoff_surface(make_height_field(Grid<double>::Zero(1, 5), 1, 1)), InputError);
}

TEST(Choose, TablesAreSpectralAndFewDirectionsAreNot) {
  const auto table = choose_estimator(kScan, {Targets::Table, 823469, 0.555, 1e-3, 2});
  EXPECT_TRUE(std::holds_alternative<Spectral>(table.estimator)) << table.reason;
  EXPECT_EQ(std::get<Spectral>(table.estimator).tolerance, 1e-3);
  const auto loose = choose_estimator(kScan, {Targets::Directions, 100, 0.555, 1e-1, 2});
  EXPECT_TRUE(std::holds_alternative<MonteCarlo>(loose.estimator)) << loose.reason;
  const auto tight = choose_estimator(kScan, {Targets::Directions, 100, 0.555, 1e-6, 2});
  EXPECT_TRUE(std::holds_alternative<Exact>(tight.estimator)) << tight.reason;
  const KirchhoffSurface tiny{8, 1, 1, 0.1, 1};
  EXPECT_TRUE(
      std::holds_alternative<Exact>(choose_estimator(tiny, {Targets::Table, 9, 0.555, 1e-6, 1}).estimator));
}

TEST(Choose, TheReasonNamesAllThree) {
  const auto choice = choose_estimator(kScan, {Targets::Directions, 7, 0.555, 1e-2, 1});
  for (const char* word : {"exact", "monte-carlo", "spectral", "predicted"})
    EXPECT_NE(choice.reason.find(word), std::string::npos) << choice.reason;
}

TEST(Choose, RefusesWhatMakesNoSense) {
  EXPECT_THROW(choose_estimator(kScan, {Targets::Table, 1, 0, 1e-3, 1}), InputError);
  EXPECT_THROW(choose_estimator(kScan, {Targets::Table, 1, 0.5, 0, 1}), InputError);
  EXPECT_THROW(choose_estimator(kScan, {Targets::Table, 1, 0.5, std::nan(""), 1}), InputError);
}

// The model of the Monte Carlo error behind the prediction holds within a factor of two for directions in the
// lobe.
TEST(Choose, PredictsTheErrorOfMonteCarlo) {
  for (const double pitch : {0.1, 0.2, 0.3}) {
    const HeightField surface = testing::gaussian_surface(100, 100, pitch, pitch, {0.14, 1.4, 1.4}, 5);
    const KirchhoffSurface s = kirchhoff_surface(surface);
    std::vector<Vec3> q;
    for (std::uint64_t k = 0; k < 40; ++k) {
      const auto [u, v] = random_normal(4, 0, k);
      const double width = s.slope / std::sqrt(2.0);
      q.push_back(wave_vector(Vec3(-width * u, -width * v, 1).normalized(), 0.555));
    }
    const double error = monte_carlo_density(surface, q, {.tolerance = 10}).error;
    // The tolerances that the prediction takes to be reached with one stratum, and to need more.
    const KirchhoffRequest easy{Targets::Directions, 40, 0.555, 3 * error, 1};
    const KirchhoffRequest hard{Targets::Directions, 40, 0.555, error / 2, 1};
    EXPECT_EQ(predict_seconds(s, easy).subdivision, 1) << pitch;
    EXPECT_GT(predict_seconds(s, hard).subdivision, 1) << pitch;
  }
}

}  // namespace
}  // namespace micro
