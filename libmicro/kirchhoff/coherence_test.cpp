#include "kirchhoff/coherence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "height/triangles.h"
#include "kirchhoff/exact.h"
#include "kirchhoff/monte_carlo.h"
#include "kirchhoff/spectral.h"
#include "testing/gaussian_surface.h"
#include "testing/kirchhoff_ensemble.h"

namespace micro {
namespace {

constexpr double kPi = std::numbers::pi;

HeightField holed(Eigen::Index rows, Eigen::Index cols) {
  HeightField surface = testing::gaussian_surface(rows, cols, 0.2, 0.25, {0.06, 1, 1}, 12);
  surface.z(3, 4) = surface.z(rows / 2, cols / 2) = kMissing;
  return surface;
}

Vec3 wave(double hx, double hy, double lambda_q) {
  return wave_vector({hx, hy, std::sqrt(1 - hx * hx - hy * hy)}, lambda_q);
}

/// F of a window cell by cell through `exact`, each with its amplitude: the literal meaning of a taper.
std::complex<double> literal_field(const Window& window, const Vec3& q) {
  const HeightField& s = window.surface;
  std::complex<double> sum = 0;
  for (Eigen::Index j = 0; j + 1 < s.rows(); ++j)
    for (Eigen::Index i = 0; i + 1 < s.cols(); ++i) {
      const HeightField cell{s.z.block(j, i, 2, 2), s.dx, s.dy, 0};
      const double amplitude = window.taper.size() ? window.taper(j, i) : 1;
      sum += amplitude * exact_field(cell, q) *
             std::polar(1.0, -q.x() * s.dx * static_cast<double>(i) - q.y() * s.dy * static_cast<double>(j));
    }
  return sum;
}

/// D of a set of windows: mean weighted by effective area.
double mean_density(const std::vector<Window>& windows, const Vec3& q) {
  double power = 0, area = 0;
  for (const Window& window : windows) {
    power += std::norm(window.taper.size() ? literal_field(window, q) : exact_field(window.surface, q));
    area += effective_area(window);
  }
  return power / (4 * kPi * kPi * area);
}

TEST(Coherence, WholePatchIsTheSurface) {
  const HeightField surface = holed(20, 30);
  const auto windows = coherent_windows(surface, WholePatch{});
  ASSERT_EQ(windows.size(), 1u);
  EXPECT_DOUBLE_EQ(effective_area(windows[0]), projected_area(surface));
}

TEST(Coherence, SubWindowsShareTheSurfaceOut) {
  const HeightField surface = holed(37, 52);
  for (const double area : {0.05, 1.0, 7.3, 25.0, 1e6, 1e300}) {
    const auto windows = coherent_windows(surface, SubWindows{area});
    double total = 0;
    std::int64_t triangles = 0;
    for (const Window& window : windows) {
      total += effective_area(window);
      triangles += triangle_count(window.surface);
    }
    EXPECT_NEAR(total, projected_area(surface), 1e-9);
    EXPECT_EQ(triangles, triangle_count(surface));
  }
  EXPECT_EQ(coherent_windows(surface, SubWindows{1e6}).size(), 1u);
  EXPECT_EQ(coherent_windows(surface, SubWindows{9.0}).size(), 3u * 3u);  // 9 × 10.2 µm in squares of 3
}

TEST(Coherence, AreaOfASource) {
  // Ω of a 9 degree cone: 2π(1 − cos 4.5°) = 0.019369 sr; sunlight (0.533°) at 0.55 µm: 4500 µm², 1.5e4 λ².
  EXPECT_NEAR(coherence_area(0.555, 9 * kPi / 180), 0.555 * 0.555 / 0.0193691, 1e-3);
  EXPECT_NEAR(coherence_area(1, 0.533 * kPi / 180), 1.47e4, 100);
  EXPECT_THROW(coherence_area(0.5, 0), InputError);
  EXPECT_THROW(coherence_area(0, 0.1), InputError);
  EXPECT_THROW(coherence_area(0.5, 4), InputError);
}

TEST(Coherence, RefusesAreasSmallerThanACell) {
  const HeightField surface = holed(20, 30);
  for (const double area : {0.0, -1.0, 0.04, std::nan(""), double(INFINITY)}) {
    EXPECT_THROW(coherent_windows(surface, SubWindows{area}), InputError);
    EXPECT_THROW(coherent_windows(surface, GaussianTaper{area}), InputError);
  }
}

TEST(Coherence, TapersAreWholeAndOverlap) {
  const HeightField surface = testing::gaussian_surface(60, 70, 0.2, 0.25, {0.05, 1, 1}, 3);
  const double s = std::sqrt(8 / (2 * kPi));
  const auto windows = coherent_windows(surface, GaussianTaper{8});
  const auto along = [s](double length) {
    return static_cast<std::size_t>(std::ceil((length - 4 * s) / (1.25 * s))) + 1;
  };
  EXPECT_EQ(windows.size(), along(69 * 0.2) * along(59 * 0.25));
  for (const Window& window :
       windows) {  // ∫W² = π s², cut at 2 s or further: erfc(2)/2 = 0.25 % on each side
    EXPECT_LE(effective_area(window) / (kPi * s * s), 1 + 1e-6);
    EXPECT_GE(effective_area(window) / (kPi * s * s), 0.99);
  }
  EXPECT_EQ(coherent_windows(surface, GaussianTaper{1e6}).size(), 1u);
}

// ∫ D m_z dω over the part of the disk that holds the lobe; slopes of rms 0.085 leave nothing beyond 0.7 but
// diffraction.
TEST(Coherence, NormalisationStays) {
  const HeightField surface = testing::gaussian_surface(29, 33, 0.2, 0.2, {0.06, 1, 1}, 12);
  const double extent = 0.9, step = 0.03;
  for (const Coherence& coherence :
       {Coherence(WholePatch{}), Coherence(SubWindows{9}), Coherence(GaussianTaper{4})}) {
    const auto windows = coherent_windows(surface, coherence);
    double sum = 0;
    std::vector<Vec3> q;
    for (double x = -extent; x <= extent; x += step)
      for (double y = -extent; y <= extent; y += step)
        if (x * x + y * y < extent * extent) q.push_back(wave(x, y, 0.555));
    double area = 0;
    for (const Window& window : windows) {
      area += effective_area(window);
      for (const FieldHalves& f : monte_carlo_field(window, q, {1, 5}))
        sum += (f.first * std::conj(f.second)).real();
    }
    const double normalization = sum * step * step / (4 * kPi * kPi * area);
    // A window 3 µm wide diffracts 2 · 2/(πkL) = 2 % past |q_⊥| = k at the rim and loses the obliquity there.
    EXPECT_NEAR(normalization, 1, 0.05) << coherence.index();
  }
}

// A plate shows the blur itself: the window's sinc², or the taper's Gaussian q_z² s²/π · e^{−s²q_⊥²}.
TEST(Coherence, BlurOfAPlateIsThatOfTheWindow) {
  const HeightField plate = make_height_field(Grid<double>::Zero(161, 161), 0.1, 0.1);
  const auto squares = coherent_windows(plate, SubWindows{16});
  ASSERT_EQ(squares.size(), 16u);
  const auto sinc = [](double x) { return x == 0 ? 1 : std::sin(x) / x; };
  const double s = std::sqrt(16 / (2 * kPi));
  const auto tapers = coherent_windows(plate, GaussianTaper{16});
  const auto widest = *std::max_element(tapers.begin(), tapers.end(), [](const Window& a, const Window& b) {
    return effective_area(a) < effective_area(b);
  });
  for (const double hx : {0.0, 0.01, 0.02, 0.04}) {
    const Vec3 q = wave(hx, 0.3 * hx, 0.555);
    const double square = std::pow(q.z() * sinc(2 * q.x()) * sinc(2 * q.y()), 2) * 16 / (4 * kPi * kPi);
    EXPECT_NEAR(mean_density(squares, q), square, 1e-6 * square);
    const double peak = q.z() * q.z() * s * s / kPi;
    const double gaussian = peak * std::exp(-s * s * (q.x() * q.x() + q.y() * q.y()));
    EXPECT_NEAR(mean_density({widest}, q), gaussian, 3e-3 * peak) << hx;  // cut at 3.5 s
  }
}

// Rough surfaces under both kinds of windows against the ensemble means that they predict.
TEST(Coherence, BlurOfRoughSurfacesIsAsPredicted) {
  constexpr int kSurfaces = 16;
  const testing::GaussianStatistics statistics{0.05, 1.5, 1.5};
  const double window_area = 9, s = std::sqrt(window_area / (2 * kPi));
  const std::vector<Vec3> q = {wave(0, 0, 0.555), wave(0.05, 0.02, 0.555), wave(0.15, 0, 0.555)};
  for (const Coherence& coherence :
       {Coherence(SubWindows{window_area}), Coherence(GaussianTaper{window_area})}) {
    std::vector<double> sum(q.size()), sum2(q.size());
    for (int k = 0; k < kSurfaces; ++k) {
      const HeightField surface =
          testing::gaussian_surface(81, 81, 0.19, 0.19, statistics, static_cast<std::uint64_t>(100 + k));
      const auto windows = coherent_windows(surface, coherence);
      const auto estimate = monte_carlo_density(windows, q, {.tolerance = 0.1});
      for (std::size_t d = 0; d < q.size(); ++d) {
        sum[d] += estimate.value[d].density;
        sum2[d] += estimate.value[d].density * estimate.value[d].density;
      }
    }
    for (std::size_t d = 0; d < q.size(); ++d) {
      const double mean = sum[d] / kSurfaces;
      const double error = std::sqrt((sum2[d] / kSurfaces - mean * mean) / (kSurfaces - 1));
      const bool squares = std::holds_alternative<SubWindows>(coherence);
      const double expected = squares ? testing::gaussian_patch_density(q[d], statistics, 3, 3)
                                      : testing::gaussian_tapered_density(q[d], statistics, s);
      // Piecewise linear heights, and tapers cut at 2 s on one side of every window at the border.
      const double systematic = squares ? 0.01 : 0.03;
      EXPECT_LE(std::abs(mean - expected), 4.5 * error + systematic * expected)
          << "windows " << coherence.index() << ", direction " << d << ": " << mean << " ± " << error
          << " against " << expected;
    }
  }
}

TEST(ExactField, TakesTapers) {
  for (const Window& window : coherent_windows(holed(45, 50), GaussianTaper{6})) {
    const std::vector<Vec3> q = {wave(0, 0, 0.555), wave(0.6, -0.3, 0.555)};
    const auto fields = exact_field(window, q);
    const double scale = q[0].norm() * effective_area(window);
    for (std::size_t k = 0; k < q.size(); ++k)
      EXPECT_LE(std::abs(fields[k] - literal_field(window, q[k])), 1e-12 * scale);
  }
}

// The taper's gradient sits on the edges of the cells; without them the table is off by percents.
TEST(SpectralSolver, TakesTapers) {
  constexpr double kTol = 1e-3, kSlack = 2;  // a small table samples few speckles
  const DiskGrid grid{33, 1};
  SpectralSolver solver(grid, 0.555, kTol);
  for (const Window& window : coherent_windows(holed(45, 50), GaussianTaper{6})) {
    const KirchhoffTable table = solver(window);
    EXPECT_TRUE(table.reached);
    double difference = 0, total = 0;
    for (Eigen::Index j = 0; j < grid.size; ++j)
      for (Eigen::Index i = 0; i < grid.size; ++i) {
        if (!(grid.mz2(j, i) > 0)) continue;
        const Vec3 q = wave(grid.coordinate(i), grid.coordinate(j), 0.555);
        const double exact = kirchhoff_density(exact_field(window, {&q, 1}).front(), effective_area(window));
        difference += std::pow(table.table.density(j, i) - exact, 2);
        total += exact * exact;
      }
    EXPECT_LE(std::sqrt(difference / total), kSlack * kTol);
  }
}

TEST(MonteCarlo, AgreesWithTheLiteralSumOverTaperedWindows) {
  const HeightField surface = holed(45, 50);
  std::vector<Vec3> q = {wave(0, 0, 0.555), wave(0.1, -0.05, 0.555), wave(0.6, 0.3, 0.555)};
  for (const Coherence& coherence : {Coherence(SubWindows{10}), Coherence(GaussianTaper{6})}) {
    const auto windows = coherent_windows(surface, coherence);
    const auto estimate = monte_carlo_density(windows, q, {.tolerance = 1e-3, .seed = 2});
    for (std::size_t k = 0; k < q.size(); ++k) {
      const double expected = mean_density(windows, q[k]);
      EXPECT_LE(std::abs(estimate.value[k].density - expected),
                5 * estimate.value[k].standard_error + 1e-6 * expected);
      EXPECT_TRUE(estimate.value[k].reached);
    }
  }
}

// One corner of a cell raised by 1: the volume below is A/6 with the diagonal beside it and A/3 with the
// diagonal through it; for small q_z the phase of F is −q_z·volume/A.
TEST(Coherence, MirroringChangesTheDiagonal) {
  Grid<double> z = Grid<double>::Zero(2, 2);
  z(0, 1) = 1;
  HeightField cell = make_height_field(z, 1, 1);
  cell.z += static_cast<float>(cell.mean);
  const Vec3 q(0, 0, 1e-4);
  EXPECT_NEAR(std::arg(exact_field(cell, q)) / q.z(), -1.0 / 6, 1e-4);
  EXPECT_NEAR(std::arg(exact_field(mirror_x(cell), q)) / q.z(), -1.0 / 3, 1e-4);
}

/// Relative L2 difference of D between the two diagonals over the lobe.
double diagonal_difference(const HeightField& surface) {
  double difference = 0, norm = 0;
  for (double hx = -0.2; hx <= 0.2; hx += 0.05)
    for (double hy = -0.2; hy <= 0.2; hy += 0.05) {
      const Vec3 q = wave(hx, hy, 0.555);
      const double d = exact_density(surface, q);
      const double other = exact_density(mirror_x(surface), {-q.x(), q.y(), q.z()});
      difference += (d - other) * (d - other);
      norm += d * d;
    }
  return std::sqrt(difference / norm);
}

// Design.md's range for measured pitches: 2e-4 to 9e-3. The difference falls with the square of the pitch.
TEST(Coherence, TheOtherDiagonalIsASmallUncertainty) {
  const testing::GaussianStatistics statistics{0.1, 1, 1};
  const HeightField fine = testing::gaussian_surface(161, 161, 0.0625, 0.0625, statistics, 8);
  HeightField coarse{Grid<float>(81, 81), 0.125, 0.125, fine.mean};
  for (Eigen::Index j = 0; j < 81; ++j)
    for (Eigen::Index i = 0; i < 81; ++i)
      coarse.z(j, i) = fine.z(2 * j, 2 * i);
  const double by_fine = diagonal_difference(fine), by_coarse = diagonal_difference(coarse);
  EXPECT_GT(by_fine, 1e-5);
  EXPECT_LT(by_fine, 9e-3);
  EXPECT_NEAR(by_coarse / by_fine, 4, 1);
}

}  // namespace
}  // namespace micro
