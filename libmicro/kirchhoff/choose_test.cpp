#include "kirchhoff/choose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <span>

#include "core/error.h"
#include "core/random.h"
#include "kirchhoff/kirchhoff.h"
#include "kirchhoff/spectral.h"
#include "testing/cosine_surface.h"
#include "testing/gaussian_surface.h"

namespace micro {
namespace {

constexpr double kLambda = 0.555;

std::vector<Window> whole(const HeightField& surface) {
  return {{surface, {}}};
}

/// What a 640 × 480 scan of rms 0.3 µm, τ = 3 µm makes; few waves are enough here.
const std::vector<Window>& scan() {
  static const std::vector<Window> windows =
      whole(testing::make_gaussian_surface({.rows = 480, .cols = 640, .waves = 10}, 1));
  return windows;
}

TEST(Choose, TablesAreSpectralAndFewDirectionsAreNot) {
  const auto table = choose_estimator(scan(), {DiskGrid{}, kLambda, 1e-3, 2});
  ASSERT_TRUE(std::holds_alternative<Spectral>(table.estimator)) << to_text(table.seconds);
  EXPECT_EQ(std::get<Spectral>(table.estimator).tolerance, 1e-3);
  // Design.md: 5.1 ms a direction for a single-point sum, 4200 s a table; seconds for the spectral estimator.
  EXPECT_GT(table.seconds.monte_carlo, 1e3);
  EXPECT_LT(table.seconds.spectral, 2);
  const auto loose = choose_estimator(scan(), {Directions{100}, kLambda, 1e-1, 2});
  EXPECT_TRUE(std::holds_alternative<MonteCarlo>(loose.estimator)) << to_text(loose.seconds);
  EXPECT_TRUE(std::isinf(loose.seconds.spectral));
  const auto tight = choose_estimator(scan(), {Directions{100}, kLambda, 1e-6, 2});
  EXPECT_TRUE(std::holds_alternative<Exact>(tight.estimator)) << to_text(tight.seconds);
  const auto tiny = whole(testing::make_gaussian_surface({.rows = 2, .cols = 5}, 1));
  const auto small = choose_estimator(tiny, {DiskGrid{3, 1}, kLambda, 1e-6, 1});
  EXPECT_TRUE(std::holds_alternative<Exact>(small.estimator)) << to_text(small.seconds);
}

TEST(Choose, TheChoiceDoesNotDependOnThreads) {
  for (const double tol : {1e-1, 1e-2, 1e-3, 1e-5}) {
    const auto one = choose_estimator(scan(), {Directions{50}, kLambda, tol, 1});
    const auto eight = choose_estimator(scan(), {Directions{50}, kLambda, tol, 8});
    EXPECT_EQ(one.estimator.index(), eight.estimator.index()) << tol;
    EXPECT_DOUBLE_EQ(one.seconds.exact, 8 * eight.seconds.exact);
  }
}

TEST(Choose, EveryWindowCosts) {
  const auto windows = coherent_windows(scan().front().surface, SubWindows{100});
  ASSERT_GT(windows.size(), 10u);
  const KirchhoffRequest request{DiskGrid{257, 1}, kLambda, 1e-3, 1};
  double alone = 0;
  for (const Window& window : windows)
    alone += predict_seconds(std::span(&window, 1), request).spectral;
  EXPECT_NEAR(predict_seconds(windows, request).spectral / alone, 1, 1e-12);
  EXPECT_NEAR(predict_seconds(windows, request).exact / predict_seconds(scan(), request).exact, 1, 1e-12);
}

TEST(Choose, ThePredictionNamesAllThree) {
  const std::string text = to_text(predict_seconds(scan(), {Directions{7}, kLambda, 1e-2, 1}));
  for (const char* word : {"exact", "monte-carlo", "spectral cannot serve"})
    EXPECT_NE(text.find(word), std::string::npos) << text;
}

TEST(Choose, RefusesWhatMakesNoSense) {
  const auto surface = whole(testing::make_gaussian_surface({.rows = 4, .cols = 5}, 1));
  EXPECT_THROW(choose_estimator(surface, {DiskGrid{3, 1}, 0, 1e-3, 1}), InputError);
  EXPECT_THROW(choose_estimator(surface, {DiskGrid{3, 1}, 0.5, 0, 1}), InputError);
  EXPECT_THROW(choose_estimator(surface, {DiskGrid{3, 1}, 0.5, std::nan(""), 1}), InputError);
  const auto line = whole(make_height_field(Grid<double>::Zero(1, 5), 1, 1));
  EXPECT_THROW(choose_estimator(line, {DiskGrid{3, 1}, 0.5, 1e-3, 1}), InputError);
}

// The work that is predicted for the spectral estimator is about the work it does.
TEST(Choose, PredictsTheWorkOfTheSpectralEstimator) {
  for (const double rms : {0.02, 0.1, 0.3, 1.0})
    for (const double extent : {0.1, 1.0})
      for (const double tol : {1e-2, 1e-4}) {
        const Window window{testing::make_gaussian_surface({.rows = 80, .cols = 90, .rms = rms}, 3), {}};
        const DiskGrid grid{65, extent};
        const SpectralChoice choice = choose_spectral(window.surface, grid, kLambda, tol);
        DiskMemory<float> memory;
        const SpectralWork done = transform_disk(window, grid, kLambda, choice, memory).work;
        const SpectralWork predicted = predict_work(window, grid, kLambda, choice);
        EXPECT_EQ(predicted.fft_length, done.fft_length);
        EXPECT_LE(std::abs(predicted.terms - done.terms), 3 + 0.25 * done.terms)
            << rms << " " << extent << " " << tol << ": " << predicted.terms << " for " << done.terms;
      }
}

// Under a spike nearly all of the time goes into tables of φ_k and c_k, by Bessel functions.
TEST(Choose, PredictsTheTablesOfGreatHeights) {
  Window window{testing::make_gaussian_surface({.rows = 20, .cols = 24}, 3), {}};
  for (const double height : {10.0, 60.0}) {
    window.surface.z(9, 11) = static_cast<float>(height);
    const DiskGrid grid{33, 1};
    const SpectralChoice choice = choose_spectral(window.surface, grid, kLambda, 1e-2);
    DiskMemory<float> memory;
    const SpectralWork done = transform_disk(window, grid, kLambda, choice, memory).work;
    SpectralWork predicted = predict_work(window, grid, kLambda, choice);
    EXPECT_NEAR(predicted.tables / done.tables, 1, 0.2) << height;
    EXPECT_NEAR(predicted.recurrences, done.recurrences, 0.3 * done.recurrences) << height;
    EXPECT_EQ(done.recurrences > 0, height == 60) << height;
    const double nodes = 33 * 33, all = table_seconds(predicted, nodes);
    predicted.tables = predicted.recurrences = 0;
    EXPECT_GT(all, 3 * table_seconds(predicted, nodes)) << height;
  }
}

// The model of the Monte Carlo error behind the prediction holds within a factor of two for directions in the
// lobe.
TEST(Choose, PredictsTheErrorOfMonteCarlo) {
  for (const double pitch : {0.1, 0.2, 0.3}) {
    const HeightField surface = testing::gaussian_surface(100, 100, pitch, pitch, {0.14, 1.4, 1.4}, 5);
    const double width = 0.14 / 1.4 * std::sqrt(2.0);  // slope per axis: σ√2/τ
    std::vector<Vec3> q;
    for (std::uint64_t k = 0; k < 40; ++k) {
      const auto [u, v] = random_normal(4, 0, k);
      q.push_back(wave_vector(Vec3(-width * u, -width * v, 1).normalized(), kLambda));
    }
    const double error = monte_carlo_density(surface, q, {.tolerance = 10}).error;
    // The tolerances that the prediction takes to be reached with one stratum, and to need more.
    const auto windows = whole(surface);
    EXPECT_EQ(predict_seconds(windows, {Directions{40}, kLambda, 3 * error, 1}).subdivision, 1) << pitch;
    EXPECT_GT(predict_seconds(windows, {Directions{40}, kLambda, error / 2, 1}).subdivision, 1) << pitch;
  }
}

}  // namespace
}  // namespace micro
