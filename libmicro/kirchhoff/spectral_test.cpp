#include "kirchhoff/spectral.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "core/error.h"
#include "height/triangles.h"
#include "kirchhoff/exact.h"
#include "testing/cosine_surface.h"

namespace micro {
namespace {

using testing::GaussianSurface;
using testing::make_gaussian_surface;
using testing::with_missing;

constexpr double kLambda = 0.555;
/// Small tables sample few speckles, so their error scatters about the one that is promised for a whole
/// table.
constexpr double kSlack = 2;

DiskTable exact_table(const HeightField& surface, const DiskGrid& grid, double lambda_q) {
  DiskTable table = make_disk_table(grid);
  std::vector<Vec3> q;
  for (Eigen::Index j = 0; j < grid.size; ++j)
    for (Eigen::Index i = 0; i < grid.size; ++i)
      if (grid.mz2(j, i) > 0)
        q.push_back(
            wave_vector(Vec3(grid.coordinate(i), grid.coordinate(j), std::sqrt(grid.mz2(j, i))), lambda_q));
  const auto fields = exact_field(surface, q);
  const double area = projected_area(surface);
  auto field = fields.begin();
  for (Eigen::Index j = 0; j < grid.size; ++j)
    for (Eigen::Index i = 0; i < grid.size; ++i)
      if (grid.mz2(j, i) > 0) table.density(j, i) = kirchhoff_density(*field++, area);
  return table;
}

/// The three promises about a table, measured on every node.
struct Measured {
  double error, core_free, median;
};

Measured measure(const DiskTable& got, const DiskTable& want, double core) {
  double difference = 0, total = 0, outer_difference = 0, outer_total = 0;
  std::vector<double> relative;
  const double peak = want.density.maxCoeff();
  for (Eigen::Index j = 0; j < got.grid.size; ++j)
    for (Eigen::Index i = 0; i < got.grid.size; ++i) {
      const double w = want.density(j, i), d = got.density(j, i) - w;
      difference += d * d;
      total += w * w;
      if (std::hypot(got.grid.coordinate(i), got.grid.coordinate(j)) > core) {
        outer_difference += d * d;
        outer_total += w * w;
      }
      if (w >= 1e-8 * peak && w > 0) relative.push_back(std::abs(d) / w);
    }
  std::nth_element(relative.begin(), relative.begin() + relative.size() / 2, relative.end());
  return {std::sqrt(difference / total), outer_total > 0 ? std::sqrt(outer_difference / outer_total) : 0,
          relative[relative.size() / 2]};
}

void expect_right(const HeightField& surface, const DiskGrid& grid, double lambda_q, double tol) {
  const KirchhoffTable got = spectral_table(surface, grid, lambda_q, tol);
  EXPECT_TRUE(got.reached);
  const Measured m =
      measure(got.table, exact_table(surface, grid, lambda_q), coherent_core(surface, lambda_q));
  EXPECT_LE(m.error, kSlack * tol);
  EXPECT_LE(m.core_free, kSlack * tol);
  EXPECT_LE(m.median, 30 * tol);
}

TEST(SpectralTable, KeepsEveryToleranceOnEveryNode) {
  const HeightField surface = make_gaussian_surface({}, 1);
  for (const double tol : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
    SCOPED_TRACE(tol);
    expect_right(surface, {65, 1}, kLambda, tol);
  }
}

struct SurfaceCase {
  std::string name;
  std::function<HeightField()> make;
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
  expect_right(c.make(), c.grid, c.lambda_q, c.tol);
}

HeightField grid_surface(Eigen::Index rows, Eigen::Index cols, double dx, double dy,
                         const std::function<double(Eigen::Index, Eigen::Index)>& z) {
  return make_height_field(Grid<double>::NullaryExpr(rows, cols, z), dx, dy);
}

const std::vector<SurfaceCase> kSurfaces = {
    {"steep", [] { return make_gaussian_surface({.rms = 1, .tau_x = 1.5, .tau_y = 1.5}, 2); }},
    {"brushed", [] { return make_gaussian_surface({.tau_x = 12, .tau_y = 1.5}, 3); }},
    {"mirror", [] { return make_gaussian_surface({.rms = 0.005}, 4); }},
    {"holes", [] { return with_missing(make_gaussian_surface({}, 5), 0.04, 6); }},
    {"mostly_missing",
     [] { return with_missing(make_gaussian_surface({}, 5), 0.7, 7); },
     {65, 1},
     kLambda,
     1e-3},
    {"missing_95_percent",
     [] { return with_missing(make_gaussian_surface({.rows = 120, .cols = 120}, 5), 0.95, 8); }},
    {"missing_border",
     [] {
       HeightField s = make_gaussian_surface({}, 9);
       s.z.row(0).setConstant(kMissing);
       s.z.row(47).setConstant(kMissing);
       s.z.leftCols(2).setConstant(kMissing);
       s.z.rightCols(3).setConstant(kMissing);
       return s;
     }},
    {"flat", [] { return grid_surface(48, 64, 0.11, 0.11, [](auto, auto) { return 0.0; }); }},
    {"one_cell",
     [] { return grid_surface(2, 2, 0.11, 0.11, [](auto j, auto i) { return 0.03 * double(i - 2 * j); }); }},
    {"one_triangle",
     [] {
       HeightField s = grid_surface(2, 2, 0.5, 0.3, [](auto j, auto i) { return 0.1 * double(i + j); });
       s.z(1, 0) = kMissing;
       return s;
     }},
    {"strip", [] { return make_gaussian_surface({.rows = 2, .cols = 300}, 10); }},
    {"column", [] { return make_gaussian_surface({.rows = 300, .cols = 2}, 11); }},
    {"tall_pixels",
     [] { return make_gaussian_surface({.rows = 24, .cols = 100, .dx = 0.05, .dy = 0.5}, 12); }},
    {"wide_pixels",
     [] { return make_gaussian_surface({.rows = 100, .cols = 24, .dx = 0.5, .dy = 0.05}, 13); }},
    {"longer_than_the_period", [] { return make_gaussian_surface({.rows = 90, .cols = 150}, 14); }, {33, 1}},
    {"many_periods", [] { return make_gaussian_surface({.rows = 60, .cols = 150}, 14); }, {9, 1}},
    {"smallest_table", [] { return make_gaussian_surface({}, 15); }, {3, 0.4}},
    {"odd_size", [] { return make_gaussian_surface({.rows = 31, .cols = 47}, 16); }, {59, 0.7}},
    {"zoomed", [] { return make_gaussian_surface({}, 17); }, {65, 0.2}},
    {"zoomed_far", [] { return make_gaussian_surface({.rms = 0.01}, 18); }, {65, 0.02}},
    {"coarse_pitch",
     [] { return make_gaussian_surface({.rows = 20, .cols = 24, .dx = 1, .dy = 1, .rms = 0.5}, 19); }},
    {"cliffs",
     [] {
       return grid_surface(40, 40, 0.5, 0.5,
                           [](auto j, auto i) { return (i / 8 + j / 10) % 2 == 0 ? 0.0 : 10.0; });
     },
     {65, 0.5},
     kLambda,
     3e-2},
    {"slopes_of_ten",
     [] { return grid_surface(32, 32, 0.1, 0.1, [](auto j, auto i) { return double((i + 2 * j) % 2); }); },
     {65, 1},
     kLambda,
     1e-2},
    {"fifty_micrometres",
     [] {
       return grid_surface(4, 101, 1, 0.5,
                           [](auto j, auto i) { return double(i) + 0.05 * std::sin(double(i * j)); });
     },
     {33, 0.75}},
    {"ten_nanometre_light", [] { return make_gaussian_surface({.rms = 0.1}, 20); }, {65, 0.04}, 0.01},
    {"metre_waves", [] { return make_gaussian_surface({}, 21); }, {65, 1}, 1e6},
    {"a_kilometre_up",
     [] {
       const HeightField s = make_gaussian_surface({.rms = 0.3}, 22);
       return make_height_field(s.z.cast<double>() + 1e6, s.dx, s.dy);
     }},
};

INSTANTIATE_TEST_SUITE_P(Zoo, SpectralSurface, ::testing::ValuesIn(kSurfaces),
                         [](const auto& which) { return which.param.name; });

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
  EXPECT_LE(measure(got.table, want, 0).error,
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
  EXPECT_TRUE(sample_error(surface, got.table, kLambda, 1e-4, 30, 1).within(1e-4));
  got.table.density *= 1.01;
  const ErrorSample sample = sample_error(surface, got.table, kLambda, 1e-4, 60, 1);
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
  const ErrorSample sample = sample_error(surface, table, kLambda, 1e-4, 25, 1);
  EXPECT_EQ(sample.nodes, 25);  // the corners lie at 0.99
  EXPECT_NEAR(sample.error(), 0.01 * peak / table.density.matrix().norm(), 1e-5 * peak);
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
