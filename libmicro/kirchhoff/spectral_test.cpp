#include "kirchhoff/spectral.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/error.h"
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

constexpr double kLambda = 0.555;
/// Small tables sample few speckles, so their error scatters about the one that is promised for a whole
/// table.
constexpr double kSlack = 2;

void expect_right(const HeightField& surface, const DiskGrid& grid, double lambda_q, double tol) {
  const KirchhoffTable got = spectral_table(surface, grid, lambda_q, tol);
  EXPECT_TRUE(got.reached);
  const testing::TableError e =
      table_error(got.table.density, exact_table(surface, grid, lambda_q), coherent_core(surface, lambda_q));
  EXPECT_LE(e.relative_l2, kSlack * tol);
  EXPECT_LE(e.core_free, kSlack * tol);
  EXPECT_LE(e.median, 30 * tol);
}

TEST(SpectralTable, KeepsEveryToleranceOnEveryNode) {
  const HeightField surface = make_gaussian_surface({}, 1);
  for (const double tol : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
    SCOPED_TRACE(tol);
    expect_right(surface, {65, 1}, kLambda, tol);
  }
}

struct SurfaceCase {
  std::string name;  ///< in the zoo
  DiskGrid grid = {65, 1};
  double lambda_q = kLambda;
  double tol = 1e-3;
};

void PrintTo(const SurfaceCase& c, std::ostream* os) {
  *os << c.name;
}

class SpectralSurface : public ::testing::TestWithParam<SurfaceCase> {};

TEST_P(SpectralSurface, EqualsExactOnEveryNode) {
  const SurfaceCase& c = GetParam();
  expect_right(zoo_surface(c.name), c.grid, c.lambda_q, c.tol);
}

const std::vector<SurfaceCase> kSurfaces = {
    {"steep"},
    {"brushed"},
    {"mirror"},
    {"holes"},
    {"mostly_missing"},
    {"missing_95_percent"},
    {"missing_border"},
    {"flat"},
    {"one_cell"},
    {"one_triangle"},
    {"strip"},
    {"column"},
    {"tall_pixels"},
    {"wide_pixels"},
    {"longer_than_the_period", {33, 1}},
    {"many_periods", {9, 1}},
    {"odd_size", {59, 0.7}},
    {"coarse_pitch"},
    {"cliffs_of_ten_micrometres", {65, 0.5}},
    {"slopes_of_ten"},
    {"a_staircase_of_thirty_micrometres", {33, 0.5}},
    {"a_hundred_micrometres", {33, 0.75}},
    {"a_metre_up"},
    {"a_spike_of_ten_micrometres"},
};

INSTANTIATE_TEST_SUITE_P(Zoo, SpectralSurface, ::testing::ValuesIn(kSurfaces),
                         [](const auto& which) { return which.param.name; });

TEST(SpectralTable, TablesOfAnySizeAndScale) {
  const HeightField rough = zoo_surface("rough");
  expect_right(rough, {3, 0.4}, kLambda, 1e-3);
  expect_right(rough, {65, 0.2}, kLambda, 1e-3);
  expect_right(make_gaussian_surface({.rms = 0.01}, 18), {65, 0.02}, kLambda, 1e-3);
  expect_right(make_gaussian_surface({.rms = 0.1}, 20), {65, 0.04}, 0.01, 1e-3);  // 10 nm light
  expect_right(rough, {65, 1}, 1e6, 1e-3);                                        // a metre
}

// The border crosses a cliff, and a hole lies in another: their edges turn by hundreds of radians.
TEST(SpectralTable, CliffsThatMeetTheBorder) {
  HeightField step = grid_surface(3, 13, 0.2, 0.2, [](auto, auto i) { return i > 6 ? 20.0 : 0.0; });
  step.z(0, 6) = kMissing;
  expect_right(step, {17, 1}, kLambda, 1e-4);
}

// Little light leaves in these directions: rounding of the bright ones must not drown it.
TEST(SpectralTable, TablesWithoutTheirLobe) {
  const HeightField stairs =
      grid_surface(29, 11, 0.11, 0.2, [](auto j, auto i) { return 0.84 * static_cast<double>((i + j) % 3); });
  expect_right(with_missing(stairs, 0.05, 1), {49, 0.22}, kLambda, 3e-4);
  const HeightField tilt =
      grid_surface(30, 5, 1.1, 1.1, [](auto j, auto) { return -1.07 * static_cast<double>(j); });
  expect_right(tilt, {17, 0.08}, 0.1744, 3e-4);
}

// c_k at the nodes themselves: fewer than a table for interpolation would have.
TEST(SpectralTable, SmallTablesOfGreatHeights) {
  const HeightField ramp =
      grid_surface(23, 7, 0.096, 0.096, [](auto j, auto) { return -0.445 * static_cast<double>(j); });
  expect_right(ramp, {17, 1}, kLambda, 1e-5);
}

TEST(SpectralTable, RefusesWhatCannotBe) {
  const HeightField surface = make_gaussian_surface({.rows = 8, .cols = 8}, 1);
  EXPECT_THROW(spectral_table(surface, {65, 1}, kLambda, 0), InputError);
  EXPECT_THROW(spectral_table(surface, {65, 1}, kLambda, std::nan("")), InputError);
  EXPECT_THROW(spectral_table(surface, {65, 1}, 0, 1e-3), InputError);
  EXPECT_THROW(spectral_table(surface, {64, 1}, kLambda, 1e-3), InputError);
  EXPECT_THROW(spectral_table(with_missing(surface, 1.1, 1), {65, 1}, kLambda, 1e-3), InputError);
  EXPECT_THROW(spectral_table(make_gaussian_surface({.rows = 1}, 1), {65, 1}, kLambda, 1e-3), InputError);
  // 10 nm light on a pitch of 1 µm, out to the horizon: the answer says how far the table may go.
  try {
    spectral_table(make_gaussian_surface({.rows = 200, .cols = 200, .dx = 1, .dy = 1}, 1), {65, 1}, 0.01,
                   1e-3);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("lower the extent towards 0.005"), std::string::npos)
        << error.what();
  }
}

TEST(SpectralTable, RefusesHigherSpikesAtOnceAndSaysWhatTheyWouldTake) {
  for (const char* name : {"a_spike_of_a_millimetre", "a_spike_of_ten_to_the_thirty"}) {
    const HeightField surface = zoo_surface(name);
    for (const double tol : {1e-2, 1e-3, 1e-6})
      try {
        spectral_table(surface, {1025, 1}, kLambda, tol);
        FAIL() << name << ' ' << tol;
      } catch (const InputError& error) {
        const std::string text = error.what();
        EXPECT_NE(text.find("spikes"), std::string::npos) << text;
        EXPECT_TRUE(text.find(" hours of a core") != std::string::npos ||
                    text.find(" days of a core") != std::string::npos ||
                    text.find(" years of a core") != std::string::npos)
            << text;
      }
  }
}

double sinc(double x) {
  return x == 0 ? 1 : std::sin(x) / x;
}

TEST(SpectralTable, TiltedPlateIsASincSquared) {
  const HeightField plate =
      grid_surface(41, 65, 0.1, 0.125, [](auto j, auto i) { return 0.03 * double(i) - 0.02 * double(j); });
  const double lx = 6.4, ly = 5, zx = 0.3, zy = -0.16;
  const DiskGrid grid = {65, 0.8};
  const KirchhoffTable got = spectral_table(plate, grid, kLambda, 1e-5);
  DiskTable want = make_disk_table(grid);
  for (Eigen::Index j = 0; j < 65; ++j)
    for (Eigen::Index i = 0; i < 65; ++i) {
      if (!(grid.mz2(j, i) > 0)) continue;
      const Vec3 q =
          wave_vector(Vec3(grid.coordinate(i), grid.coordinate(j), std::sqrt(grid.mz2(j, i))), kLambda);
      const double field = (q.z() - zx * q.x() - zy * q.y()) * lx * ly * sinc((q.x() + zx * q.z()) * lx / 2) *
                           sinc((q.y() + zy * q.z()) * ly / 2);
      want.density(j, i) = kirchhoff_density(field, lx * ly);
    }
  EXPECT_LE(table_error(got.table.density, want, 0).relative_l2,
            2e-5);  // heights are rounded to float: 1e-7 of 1.9 µm is 4e-6 rad
}

TEST(SpectralTable, SinusoidHasBesselOrders) {
  // Whole periods of h = a cos(gx), sampled finely: at order n, q_x = n·g, and the peak is
  // D = (|q|²/q_z)² J_n(q_z a)² A/4π² [Beckmann & Spizzichino 1963, §4.3].
  constexpr int kPeriods = 8, kPerPeriod = 64, kSize = 33;
  const double amplitude = 0.2, period = 4, dx = period / kPerPeriod;
  const HeightField surface = grid_surface(9, kPeriods * kPerPeriod + 1, dx, 0.5, [&](auto, auto i) {
    return amplitude * std::cos(2 * M_PI * double(i) / kPerPeriod);
  });
  // Node spacing = one order: h_x = n λ_q/(2·period).
  const DiskGrid grid = {kSize, (kSize - 1) / 2 * kLambda / (2 * period) * 0.5};
  const KirchhoffTable got = spectral_table(surface, grid, kLambda, 1e-5);
  const double area = period * kPeriods * 4.0;
  double peak = 0, worst = 0;
  for (int n = -8; n <= 8; ++n) {
    const double sx = n * kLambda / (2 * period), cz = std::sqrt(1 - sx * sx);
    const Vec3 q = wave_vector(Vec3(sx, 0, cz), kLambda);
    const double bessel = std::cyl_bessel_j(std::abs(n), q.z() * amplitude);
    const double want = kirchhoff_density(q.squaredNorm() / q.z() * bessel * area, area);
    peak = std::max(peak, want);
    worst = std::max(worst, std::abs(got.table.density(16, 16 + 2 * n) - want));
  }
  // The triangulation flattens the crests: a·(g·dx)²/8 = 2.4e-4 µm, 5e-3 rad, so a few 1e-3 of D.
  EXPECT_LE(worst, 1e-2 * peak);
  EXPECT_GT(peak, 0);
}

TEST(SpectralTable, TwoLevelGratingExtinguishesTheMirrorDirection) {
  // Equal areas at two heights a quarter of λ_q apart: q_z·d = π, so D(0) = sin²-free zero but for the steep
  // walls.
  const double depth = kLambda / 4;
  const HeightField surface =
      grid_surface(5, 401, 0.05, 1, [&](auto, auto i) { return (i / 20) % 2 == 0 ? 0.0 : depth; });
  const KirchhoffTable got = spectral_table(surface, {33, 0.5}, kLambda, 1e-3);
  const KirchhoffTable plate =
      spectral_table(grid_surface(5, 401, 0.05, 1, [](auto, auto) { return 0.0; }), {33, 0.5}, kLambda, 1e-3);
  EXPECT_LE(got.table.density(16, 16), 3e-3 * plate.table.density(16, 16));
}

TEST(SpectralTable, SmoothSurfacesReflectEverything) {
  const HeightField surface = make_gaussian_surface({.rows = 180, .cols = 240, .rms = 0.1}, 31);
  const KirchhoffTable got = spectral_table(surface, {513, 1}, kLambda, 1e-3);
  // What is missing is diffracted at the rim beyond the horizon: about λ_q/(π²)·(1/Lx + 1/Ly) of it.
  EXPECT_NEAR(normalization(got.table), 1, 0.02);
}

TEST(SpectralTable, Invariances) {
  const HeightField surface = with_missing(make_gaussian_surface({}, 41), 0.02, 42);
  const DiskGrid grid = {65, 1};
  constexpr double kTol = 1e-4;
  const auto table = [&](const HeightField& s, double lambda_q) {
    return spectral_table(s, grid, lambda_q, kTol).table;
  };
  const DiskTable plain = table(surface, kLambda);
  const auto difference = [&](const Grid<double>& other) {
    return std::sqrt((other - plain.density).square().sum() / plain.density.square().sum());
  };
  HeightField lifted = surface;
  lifted.z += 2;
  EXPECT_LE(difference(table(lifted, kLambda).density), 2 * kTol);
  HeightField turned = surface;
  turned.z = surface.z.reverse().eval();  // half a turn keeps the triangulation
  EXPECT_LE(difference(table(turned, kLambda).density.reverse()), 2 * kTol);
  HeightField mirrored = surface;
  mirrored.z = surface.z.transpose().eval();  // the diagonal is the mirror's own
  EXPECT_LE(difference(table(mirrored, kLambda).density.transpose()), 2 * kTol);
  HeightField larger = surface;
  larger.z *= 3;
  larger.dx *= 3;
  larger.dy *= 3;
  EXPECT_LE(difference(table(larger, 3 * kLambda).density), 2 * kTol);
  HeightField padded = surface;  // missing points around it move it, no more
  padded.z = Grid<float>::Constant(60, 80, kMissing);
  padded.z.block(7, 11, 48, 64) = surface.z;
  EXPECT_LE(difference(table(padded, kLambda).density), 2 * kTol);
}

TEST(SpectralSolver, SameTableForAnyNumberOfThreadsAndAnyHistory) {
  const HeightField surface = make_gaussian_surface({}, 51),
                    other = with_missing(make_gaussian_surface({.rms = 1}, 52), 0.1, 1);
  SpectralSolver solver({65, 1}, kLambda, 1e-3);
  const KirchhoffTable first = solver(surface);
  solver(other);
  EXPECT_TRUE((first.table.density == solver(surface).table.density).all());
}

TEST(ErrorSample, FindsADeliberateError) {
  const HeightField surface = make_gaussian_surface({}, 61);
  KirchhoffTable got = spectral_table(surface, {65, 1}, kLambda, 1e-5);
  EXPECT_TRUE(sample_error(Window{surface, {}}, got.table.grid, got.table.density, kLambda, 1e-4, 30, 1)
                  .within(1e-4));
  got.table.density *= 1.01;
  const ErrorSample sample =
      sample_error(Window{surface, {}}, got.table.grid, got.table.density, kLambda, 1e-4, 60, 1);
  // A common factor: Δ²/D̂² is the same at all nodes, so only the mixture of draws scatters.
  EXPECT_NEAR(sample.error(), 0.01 / 1.01, 0.003);
  EXPECT_NEAR(sample.error_core_free(), 0.01 / 1.01, 0.004);
  EXPECT_EQ(sample.significant, 15);
  EXPECT_GE(sample.significant_bad, 12);  // near D's zeros the table's own error may cancel it
  EXPECT_FALSE(sample.within(1e-3));
}

TEST(ErrorSample, TakesEveryNodeOfASmallTable) {
  const HeightField surface = make_gaussian_surface({}, 61);
  DiskTable table = spectral_table(surface, {5, 0.7}, kLambda, 1e-5).table;
  const double peak = table.density.maxCoeff();
  table.density(2, 1) += 0.01 * peak;
  const ErrorSample sample =
      sample_error(Window{surface, {}}, table.grid, table.density, kLambda, 1e-4, 25, 1);
  EXPECT_EQ(sample.nodes, 25);  // the corners lie at 0.99
  EXPECT_NEAR(sample.error(), 0.01 * peak / table.density.matrix().norm(), 1e-5 * peak);
}

// A checker of a nanometre's steps: of the energy next to nothing lies outside the core, and the dozen nodes
// that a large scan affords would not find its error of two tolerances.
TEST(ErrorSample, SeesTheTailOfASmallSmoothSurface) {
  const HeightField checker = grid_surface(
      12, 28, 0.1286, 0.1286, [](auto j, auto i) { return (i / 5 + j / 2) % 2 == 0 ? 0.0 : 0.0068; });
  expect_right(checker, {33, 1}, kLambda, 1e-3);
}

TEST(ErrorSample, Pools) {
  ErrorSample a{3, 3e-6, 6e-6, 1, 0};
  a += ErrorSample{3, 9e-6, 0, 1, 1};
  EXPECT_EQ(a.nodes, 6);
  EXPECT_DOUBLE_EQ(a.error(), std::sqrt(2e-6));
  EXPECT_DOUBLE_EQ(a.error_core_free(), 1e-3);
  EXPECT_TRUE(a.within(0.01));
  EXPECT_FALSE(a.within(1.2e-3));
}

}  // namespace
}  // namespace micro
