#include "kirchhoff/spectrum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "kirchhoff/kirchhoff.h"
#include "testing/cosine_surface.h"
#include "testing/exact_table.h"
#include "testing/zoo.h"

namespace micro {
namespace {

using testing::exact_table;
using testing::grid_surface;
using testing::make_gaussian_surface;
using testing::table_error;
using testing::with_missing;
using testing::zoo_surface;

/// Small tables sample few speckles, so their error scatters about the one that is promised for a whole
/// table.
constexpr double kSlack = 2;

const std::vector<double> kVisible = {0.38, 0.47, 0.555, 0.63, 0.78};

double relative_l2(const Grid<double>& got, const Grid<double>& want) {
  return std::sqrt((got - want).square().sum() / want.square().sum());
}

/// Both L2 promises against `exact` on every node, and the median's.
void expect_right(const HeightField& surface, const DiskGrid& grid, double lambda_q, double tol,
                  const SpectrumTable& table) {
  SCOPED_TRACE(lambda_q);
  EXPECT_TRUE(table.reached);
  const testing::TableError e = table_error(
      table.density.cast<double>(), exact_table(surface, grid, lambda_q), coherent_core(surface, lambda_q));
  EXPECT_LE(e.relative_l2, kSlack * tol);
  EXPECT_LE(e.core_free, kSlack * tol);
  EXPECT_LE(e.median, 30 * tol);
}

struct SpectrumCase {
  std::string name;  ///< in the zoo
  DiskGrid grid = {49, 1};
  double tol = 1e-3;
  std::vector<double> lambda_q = {0.38, 0.555, 0.78};
};

void PrintTo(const SpectrumCase& c, std::ostream* os) {
  *os << c.name;
}

class SpectrumSurface : public ::testing::TestWithParam<SpectrumCase> {};

TEST_P(SpectrumSurface, EqualsExactOnEveryNode) {
  const SpectrumCase& c = GetParam();
  const HeightField surface = zoo_surface(c.name);
  const KirchhoffSpectrum spectrum = SpectrumSolver(c.grid, c.lambda_q, c.tol)(surface);
  ASSERT_EQ(spectrum.tables.size(), c.lambda_q.size());
  EXPECT_TRUE(spectrum.shared);
  for (std::size_t k = 0; k < c.lambda_q.size(); ++k)
    expect_right(surface, c.grid, c.lambda_q[k], c.tol, spectrum.tables[k]);
}

const std::vector<SpectrumCase> kSurfaces = {
    {"rough", {65, 1}, 1e-3, kVisible},
    {"steep"},
    {"mirror"},
    {"holes"},
    {"mostly_missing"},
    {"missing_border"},
    {"flat"},
    {"one_cell"},
    {"one_triangle"},
    {"strip"},
    {"column"},
    {"tall_pixels"},
    {"many_periods", {9, 1}},
    {"cliffs_of_ten_micrometres", {33, 0.5}, 3e-2, {0.5, 0.555, 0.78}},
    {"a_staircase_of_thirty_micrometres", {25, 0.75}, 1e-2},
};

INSTANTIATE_TEST_SUITE_P(Zoo, SpectrumSurface, ::testing::ValuesIn(kSurfaces),
                         [](const auto& which) { return which.param.name; });

void expect_spectrum_right(const HeightField& surface, const DiskGrid& grid, double tol,
                           const std::vector<double>& lambda_q) {
  const KirchhoffSpectrum spectrum = SpectrumSolver(grid, lambda_q, tol)(surface);
  for (std::size_t k = 0; k < lambda_q.size(); ++k)
    expect_right(surface, grid, lambda_q[k], tol, spectrum.tables[k]);
}

TEST(SpectrumSolver, TablesAndWavelengthsOfAnyScale) {
  const HeightField rough = zoo_surface("rough");
  expect_spectrum_right(rough, {3, 0.4}, 1e-3, {0.38, 0.555, 0.78});
  expect_spectrum_right(rough, {49, 0.2}, 1e-3, {0.38, 0.555, 0.78});
  expect_spectrum_right(rough, {33, 0.7}, 1e-3, {0.4, 4, 40});
  expect_spectrum_right(rough, {33, 1}, 1e-3, {0.5e6, 1e6});
  expect_spectrum_right(make_gaussian_surface({.rms = 0.1}, 20), {33, 0.04}, 1e-3, {0.01, 0.013});
  expect_spectrum_right(make_gaussian_surface({.rows = 30, .cols = 40}, 1), {33, 1}, 1e-5,
                        {0.38, 0.555, 0.78});
}

TEST(SpectrumSolver, AgreesWithSeparateRuns) {
  const HeightField surface = make_gaussian_surface({.rows = 80, .cols = 120}, 31);
  const DiskGrid grid = {129, 1};
  constexpr double kTol = 1e-3;
  const KirchhoffSpectrum spectrum = SpectrumSolver(grid, kVisible, kTol)(surface);
  for (std::size_t k = 0; k < kVisible.size(); ++k)
    EXPECT_LE(relative_l2(spectrum.tables[k].density.cast<double>(),
                          spectral_table(surface, grid, kVisible[k], kTol).table.density),
              2 * kTol);
}

TEST(SpectrumSolver, OrdersOfASinusoidMoveWithTheWavelength) {
  // As in SpectralTable.SinusoidHasBesselOrders; order n stands at h_x = n λ_q/(2·period), on a node of the
  // table for each of the wavelengths.
  constexpr int kPeriods = 8, kPerPeriod = 64, kHalf = 64, kSteps = 4;
  const double amplitude = 0.2, period = 4, dx = period / kPerPeriod, step = 0.1;
  const HeightField surface = grid_surface(9, kPeriods * kPerPeriod + 1, dx, 0.5, [&](auto, auto i) {
    return amplitude * std::cos(2 * M_PI * double(i) / kPerPeriod);
  });
  const DiskGrid grid = {2 * kHalf + 1, kHalf * step / kSteps / (2 * period)};
  const std::vector<double> lambda_q = {0.4, 0.5, 0.7};
  const KirchhoffSpectrum spectrum = SpectrumSolver(grid, lambda_q, 1e-4)(surface);
  const double area = period * kPeriods * 4.0;
  for (std::size_t k = 0; k < lambda_q.size(); ++k) {
    const int nodes = static_cast<int>(std::lround(lambda_q[k] / step)) * kSteps;
    double peak = 0, worst = 0, between = 0;
    for (int n = -kHalf / nodes; n <= kHalf / nodes; ++n) {
      const double sx = n * lambda_q[k] / (2 * period), cz = std::sqrt(1 - sx * sx);
      const Vec3 q = wave_vector(Vec3(sx, 0, cz), lambda_q[k]);
      const double bessel = std::cyl_bessel_j(std::abs(n), q.z() * amplitude);
      const double want = kirchhoff_density(q.squaredNorm() / q.z() * bessel * area, area);
      peak = std::max(peak, want);
      worst = std::max(worst, std::abs(spectrum.tables[k].density(kHalf, kHalf + n * nodes) - want));
    }
    // Whole periods: nothing halfway between orders, where sinc² of an even number of periods is zero.
    for (int n = nodes / 2 - kHalf / nodes * nodes; n < kHalf; n += nodes)
      between = std::max<double>(between, spectrum.tables[k].density(kHalf, kHalf + n));
    // The triangulation flattens the crests: a few 1e-3 of D.
    EXPECT_LE(worst, 1e-2 * peak);
    EXPECT_GT(peak, 0);
    EXPECT_LE(between, 1e-2 * peak);
  }
}

TEST(SpectrumSolver, SameTablesForAnyNumberOfThreadsAndAnyHistory) {
  const HeightField surface = make_gaussian_surface({}, 51),
                    other = with_missing(make_gaussian_surface({.rms = 1}, 52), 0.1, 1);
  SpectrumSolver solver({65, 1}, kVisible, 1e-3);
  const KirchhoffSpectrum first = solver(surface);
  solver(other);
  const int threads = thread_count();
  set_thread_count(threads == 1 ? 3 : 1);
  const KirchhoffSpectrum again = solver(surface);
  set_thread_count(threads);
  for (std::size_t k = 0; k < kVisible.size(); ++k)
    EXPECT_TRUE((first.tables[k].density == again.tables[k].density).all());
}

TEST(SpectrumSolver, LargePatchesAreDoneOneByOne) {
  const HeightField surface = make_gaussian_surface({}, 61);
  const DiskGrid grid = {33, 1};
  const KirchhoffSpectrum spectrum = SpectrumSolver(grid, {0.4, 0.6}, 1e-3, 1000)(surface);
  EXPECT_FALSE(spectrum.shared);
  expect_right(surface, grid, 0.4, 1e-3, spectrum.tables[0]);
  expect_right(surface, grid, 0.6, 1e-3, spectrum.tables[1]);
}

TEST(SpectrumSolver, SaysWhatItMissed) {
  // Tables are float.
  constexpr double kTol = 1e-9;
  const KirchhoffSpectrum spectrum =
      SpectrumSolver({9, 0.3}, {0.5, 0.6}, kTol)(make_gaussian_surface({.rows = 12, .cols = 12}, 1));
  for (const SpectrumTable& table : spectrum.tables) {
    EXPECT_FALSE(table.reached);
    EXPECT_GT(table.error.error(), kTol);
  }
}

TEST(SpectrumSolver, RefusesWhatCannotBe) {
  EXPECT_THROW(SpectrumSolver({65, 1}, {}, 1e-3), InputError);
  EXPECT_THROW(SpectrumSolver({65, 1}, {0.5, 0.4}, 1e-3), InputError);
  EXPECT_THROW(SpectrumSolver({65, 1}, {0.5, 0.5}, 1e-3), InputError);
  EXPECT_THROW(SpectrumSolver({65, 1}, {0, 0.5}, 1e-3), InputError);
  EXPECT_THROW(SpectrumSolver({64, 1}, {0.5}, 1e-3), InputError);
  EXPECT_THROW(SpectrumSolver({65, 1}, {0.5}, 0), InputError);
  SpectrumSolver solver({65, 1}, {0.5}, 1e-3);
  EXPECT_THROW(solver(with_missing(make_gaussian_surface({}, 1), 1.1, 1)), InputError);
  EXPECT_THROW(solver(zoo_surface("a_spike_of_a_millimetre")), InputError);
  EXPECT_THROW(solver(zoo_surface("a_spike_of_ten_to_the_thirty")), InputError);
}

}  // namespace
}  // namespace micro
