#include "distribution/tabulated.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/random.h"
#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"
#include "distribution/scatter.h"
#include "distribution/tabulate.h"
#include "testing/chi_square.h"

namespace micro {
namespace {

constexpr double kPi = std::numbers::pi;

Vec3 direction(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

Vec3 normal_at(double x, double y) {
  return {x, y, std::sqrt(1 - x * x - y * y)};
}

/// Rough tables: every node its own random value, a third of them zero.
DiskTable random_table(const DiskGrid& grid, std::uint64_t seed) {
  DiskTable table = make_disk_table(grid);
  for (Eigen::Index j = 0; j < grid.size; ++j)
    for (Eigen::Index i = 0; i < grid.size; ++i)
      if (grid.mz2(j, i) > 0) {
        const double value = random_uniform(seed, 0, static_cast<std::uint64_t>(j * grid.size + i))[0];
        table.density(j, i) = std::max(0., 1.5 * value - 0.5);
      }
  return table;
}

/// Tables of all kinds, of few enough nodes to take each cell for a bin.
std::vector<DiskTable> small_tables() {
  DiskTable one_node = make_disk_table({15, 0.3});
  one_node.density(9, 4) = 7;
  return {random_table({15, 0.6}, 1), random_table({21, 1}, 2), one_node,
          tabulate(Ellipsoid(slope_frame({0.3, 0.1, 0.2, 0.4, 0.5})), {21, 1}),
          tabulate(Ellipsoid(slope_frame({0.2, 0.1, 1.1, 0.2, 0.5})), {65, 1}),
          // Nodes on the horizon by Pythagoras' triples, and within 1e-7 of it.
          tabulate(Ellipsoid(slope_frame({0.2, 0.1, 1.1, 0.2, 0.5})), {51, 1}),
          random_table({51, 1 - 1e-8}, 3)};
}

/// ∫ f dm_x dm_y over each cell of the table by `steps`² midpoints.
template <typename F>
std::vector<double> integrate_cells(const DiskGrid& grid, int steps, F&& f) {
  const int n = grid.size - 1;
  const double h = grid.spacing() / steps;
  std::vector<double> sums(static_cast<std::size_t>(n) * n, 0.);
  for (int j = 0; j < n * steps; ++j)
    for (int i = 0; i < n * steps; ++i) {
      const double x = -grid.extent + (i + 0.5) * h, y = -grid.extent + (j + 0.5) * h;
      if (x * x + y * y < 1)
        sums[static_cast<std::size_t>(j / steps * n + i / steps)] += f(normal_at(x, y)) * h * h;
    }
  return sums;
}

double sum(const std::vector<double>& values) {
  double total = 0;
  for (const double value : values)
    total += value;
  return total;
}

TEST(Tabulated, IsBilinear) {
  const DiskTable table = random_table({15, 0.6}, 1);
  const Tabulated tabulated(table);
  const DiskGrid& grid = table.grid;
  EXPECT_NEAR(tabulated.D(normal_at(grid.coordinate(3), grid.coordinate(8))), table.density(8, 3), 1e-12);
  EXPECT_NEAR(tabulated.D(normal_at(0.6, 0.6)), table.density(14, 14), 1e-12);
  const double x = grid.coordinate(3) + grid.spacing() / 4, y = grid.coordinate(8) + grid.spacing() / 2;
  const double expected = (0.75 * (table.density(8, 3) + table.density(9, 3)) +
                           0.25 * (table.density(8, 4) + table.density(9, 4))) /
                          2;
  EXPECT_NEAR(tabulated.D(normal_at(x, y)), expected, 1e-12);
  EXPECT_EQ(tabulated.D(normal_at(0.7, 0)), 0);
  EXPECT_EQ(tabulated.D(-normal_at(0.1, 0)), 0);
}

TEST(Tabulated, PdfsIntegrateToOne) {
  for (const DiskTable& table : small_tables()) {
    const Tabulated tabulated(table);
    const double mass = sum(integrate_cells(table.grid, 20, [&](const Vec3& m) { return tabulated.D(m); }));
    EXPECT_NEAR(tabulated.mass(), mass, 1e-10 * mass);
    for (const double theta : {0., 0.8, 1.5}) {
      const Vec3 u = direction(theta, 2.2);
      const double visible = sum(integrate_cells(
          table.grid, 20, [&](const Vec3& m) { return tabulated.pdf_visible(u, m) / m.z(); }));
      constexpr double kInterpolated = 0.01;  // the masking table's own error, on rough tables
      EXPECT_NEAR(visible, 1, kInterpolated) << theta;
    }
  }
}

TEST(Tabulated, SamplesFollowTheirDensities) {
  constexpr int kSamples = 20000;
  constexpr double kSmallestP = 1e-5;
  std::uint32_t stream = 0;
  for (const DiskTable& table : small_tables()) {
    const Tabulated tabulated(table);
    const DiskGrid& grid = table.grid;
    const auto expect_sampled = [&](auto&& density, auto&& sample) {
      std::vector<double> expected = integrate_cells(grid, 12, density);
      const double total = sum(expected);
      for (double& e : expected)
        e *= kSamples / total;
      std::vector<double> counts(expected.size(), 0.);
      ++stream;
      for (std::uint64_t k = 0; k < kSamples; ++k) {
        const auto [a, b] = random_uniform(3, stream, k);
        const Vec3 m = sample(Vec2(a, b));
        ASSERT_NEAR(m.norm(), 1, 1e-12);
        const auto i = static_cast<int>((m.x() + grid.extent) / grid.spacing()),
                   j = static_cast<int>((m.y() + grid.extent) / grid.spacing());
        counts[static_cast<std::size_t>(std::min(j, grid.size - 2) * (grid.size - 1) +
                                        std::min(i, grid.size - 2))] += 1;
      }
      EXPECT_GT(testing::chi_square_p(counts, expected), kSmallestP) << "table " << stream;
    };
    expect_sampled([&](const Vec3& m) { return tabulated.D(m); },
                   [&](const Vec2& xi) { return tabulated.sample(xi); });
    for (const Vec3& u : {direction(0.6, 1), direction(1.55, 4), direction(1.3, 0)})
      expect_sampled([&](const Vec3& m) { return tabulated.D(m) * std::max(0., m.dot(u)) / m.z(); },
                     [&](const Vec2& xi) { return tabulated.sample_visible(u, xi); });
  }
}

// Inside one cell too: the places of samples, by the conditional distribution functions of the bilinear
// density.
TEST(Tabulated, SamplesAreBilinearInsideACell) {
  DiskTable table = make_disk_table({3, 0.5});
  table.density << 0, 0, 0, 0, 1, 5, 0, 3, 0.5;
  const Tabulated tabulated(table);
  constexpr int kBins = 6, kSamples = 40000;
  std::vector<double> counts(kBins * kBins, 0.), expected(kBins * kBins, 0.);
  for (int j = 0; j < kBins * 20; ++j)
    for (int i = 0; i < kBins * 20; ++i)
      expected[static_cast<std::size_t>(j / 20 * kBins + i / 20)] +=
          tabulated.D(normal_at((i + 0.5) / (40 * kBins), (j + 0.5) / (40 * kBins)));
  int inside = 0;
  for (std::uint64_t k = 0; k < kSamples; ++k) {
    const auto [a, b] = random_uniform(4, 0, k);
    const Vec3 m = tabulated.sample({a, b});
    if (m.x() < 0 || m.y() < 0) continue;
    ++inside;
    counts[static_cast<std::size_t>(static_cast<int>(m.y() * 2 * kBins) * kBins +
                                    static_cast<int>(m.x() * 2 * kBins))] += 1;
  }
  const double total = sum(expected);
  for (double& e : expected)
    e *= inside / total;
  EXPECT_GT(testing::chi_square_p(counts, expected), 1e-4);
}

TEST(Tabulated, VisibleAreaIsItsIntegral) {
  for (const DiskTable& table : small_tables()) {
    const Tabulated tabulated(table);
    for (const double theta : {0., 0.4, 1.1, 1.5})
      for (const double phi : {0.1, 2., 4.4}) {
        const Vec3 u = direction(theta, phi);
        const double area = sum(integrate_cells(
            table.grid, 20, [&](const Vec3& m) { return tabulated.D(m) * std::max(0., m.dot(u)) / m.z(); }));
        constexpr double kInterpolated = 2e-3;
        EXPECT_NEAR(tabulated.visible_area(u), area, kInterpolated * area + 1e-8 * tabulated.mass())
            << theta << " " << phi;
        EXPECT_LE(tabulated.G1(u) * tabulated.visible_area(u), tabulated.mass() * u.z() * (1 + 1e-12));
      }
  }
}

// A table that resolves a model masks as the model does.
TEST(Tabulated, MaskingIsThatOfTheModel) {
  constexpr double kResolved = 2e-3;
  const auto expect_same = [&](const auto& model, const DiskGrid& grid) {
    const Tabulated tabulated(tabulate(model, grid));
    for (double theta = 0.05; theta < 1.57; theta += 0.1)
      for (const double phi : {0., 0.7, 2.1, 5.}) {
        const Vec3 u = direction(theta, phi);
        EXPECT_NEAR(tabulated.G1(u), model.G1(u), kResolved) << theta << " " << phi;
      }
  };
  expect_same(Beckmann(slope_frame({0.2, 0.2, 0, 0, 0})), {257, 1});
  expect_same(Beckmann(slope_frame({0.3, 0.01, 0, 0, 0.3})), {513, 1});
  expect_same(Beckmann(slope_frame({0.1, 0.05, 0.4, 0.2, 0.3})), {513, 1});
  expect_same(Beckmann(slope_frame({0.002, 0.001, 0, 0, 0.3})), {257, 0.01});
}

TEST(Tabulated, GgxLosesOnlyItsFarTail) {
  const Ellipsoid model = ggx(0.1);
  const Tabulated tabulated(tabulate(model, {513, 1}));
  constexpr double kTail = 6e-3;  // slopes beyond 9 lie in the ring that the horizon cuts
  for (double theta = 0.05; theta < 1.57; theta += 0.1)
    EXPECT_NEAR(tabulated.G1(direction(theta, 1)), model.G1(direction(theta, 1)), kTail);
}

// Scaling a table scales its mass and nothing else: a table that holds part of the energy masks as that part
// does.
TEST(Tabulated, MaskingDoesNotDependOnTheScale) {
  DiskTable table = random_table({15, 0.6}, 1);
  const Tabulated one(table);
  table.density *= 0.37;
  const Tabulated other(table);
  const Vec3 u = direction(1.2, 1);
  EXPECT_NEAR(one.G1(u), other.G1(u), 1e-6);
  EXPECT_NEAR(one.pdf_visible(u, normal_at(0.1, 0.1)), other.pdf_visible(u, normal_at(0.1, 0.1)), 1e-6);
}

// Needles that fall between the nodes, a lobe on the rim, the whole disk alike: finite, in range, drawn from
// the upper hemisphere.
TEST(Tabulated, ZooIsFinite) {
  DiskTable flat = make_disk_table({65, 1}), rim = flat, centre = flat;
  for (Eigen::Index j = 0; j < 65; ++j)
    for (Eigen::Index i = 0; i < 65; ++i)
      flat.density(j, i) = flat.grid.mz2(j, i) > 0 ? 1 / kPi : 0;
  rim.density(32, 62) = 1e9;
  centre.density(32, 32) = 1e-30;
  DiskTable spike = flat;
  spike.density(20, 33) = 1e12;
  for (const DiskTable& table : {flat, rim, centre, spike}) {
    const Tabulated tabulated(table);
    for (std::uint64_t k = 0; k < 100; ++k) {
      const auto [a, b] = random_uniform(6, 0, k);
      const Vec3 u = k % 4 == 0 ? direction(kPi / 2 - 1e-6, 6 * a) : direction(kPi / 2 * b, 6 * a);
      const Vec2 xi = k == 0 ? Vec2(0, 0) : k == 1 ? Vec2(1 - 0x1p-53, 1 - 0x1p-53) : Vec2(b, a);
      EXPECT_GE(tabulated.G1(u), 0);
      EXPECT_LE(tabulated.G1(u), 1);
      for (const Vec3& m : {tabulated.sample(xi), tabulated.sample_visible(u, xi)}) {
        EXPECT_NEAR(m.norm(), 1, 1e-12);
        EXPECT_GE(m.z(), 0);
        EXPECT_GE(tabulated.pdf(m), 0);
        EXPECT_GE(tabulated.pdf_visible(u, m), 0);
        EXPECT_LE(tabulated.pdf_visible(u, m), 1e15);
      }
    }
  }
}

// A lobe that leans away: less and less of it is seen, at last nothing. Samples follow pdf_visible all the
// way, which stays a density.
TEST(Tabulated, SamplesFollowTheirDensitiesWhereHardlyAnythingIsVisible) {
  constexpr int kSamples = 1000;
  constexpr double kSmallestP = 1e-4, kInterpolated = 0.01;
  const DiskTable table = tabulate(Beckmann(slope_frame({0.1, 0.1, 0, 0.8, 0})), {65, 1});
  const Tabulated tabulated(table);
  int fallen_back = 0, seen_in_part = 0;
  for (const double theta : {0.5, 0.8, 0.9, 0.95, 1.05, 1.2, 1.35})
    for (const double phi : {0., kPi}) {
      const Vec3 u = direction(theta, phi);
      std::vector<double> expected =
          integrate_cells(table.grid, 6, [&](const Vec3& m) { return tabulated.pdf_visible(u, m) / m.z(); });
      const double total = sum(expected);
      EXPECT_NEAR(total, 1, kInterpolated) << theta << " " << phi;
      for (double& e : expected)
        e *= kSamples / total;
      std::vector<double> counts(expected.size(), 0.);
      for (std::uint64_t k = 0; k < kSamples; ++k) {
        const auto [a, b] = random_uniform(8, static_cast<std::uint32_t>(100 * theta + phi), k);
        const Vec3 m = tabulated.sample_visible(u, {a, b});
        const auto cell = [&](double x) { return static_cast<std::size_t>((x + 1) / table.grid.spacing()); };
        counts[cell(m.y()) * 64 + cell(m.x())] += 1;
      }
      EXPECT_GT(testing::chi_square_p(counts, expected), kSmallestP) << theta << " " << phi;
      const double share = tabulated.visible_area(u) / tabulated.mass();
      (share < 1e-5 ? fallen_back : seen_in_part) += share < 0.05 ? 1 : 0;
    }
  EXPECT_GE(fallen_back, 2);
  EXPECT_GE(seen_in_part, 1);
}

// Views that see next to nothing: from below the lobe's own horizon, to where samples fall back on pdf.
// Smooth lobes keep their promise; a single node's end falls between the masking table's nodes.
TEST(Tabulated, HardlyVisibleNormalsIntegrateToOneWithinTheStatedBounds) {
  const DiskTable lobe = tabulate(Beckmann(slope_frame({0.1, 0.1, 0, 0.8, 0})), {65, 1});
  DiskTable node = make_disk_table({33, 0.5});
  node.density(20, 25) = 3;
  for (const auto& [table, bound] : {std::pair(&lobe, 1.5e-3), {&node, 0.12}}) {
    const Tabulated tabulated(*table);
    const SlopeFrame frame = slope_scatter(core_nodes(*table, 8192), table->grid);
    int views = 0;
    for (std::uint64_t k = 0; k < 60; ++k) {
      const auto [a, b] = random_uniform(11, 0, k);
      const double phi = 2 * kPi * a, y = std::sin(phi) / frame.l22,
                   x = (std::cos(phi) - frame.l21 * y) / frame.l11;
      const Vec3 u = Vec3(x, y, frame.centre.dot(Vec2(x, y)) - 1.5 - 4 * b).normalized();
      if (!(u.z() > 0)) continue;
      ++views;
      const double total = sum(integrate_cells(
          table->grid, 12, [&](const Vec3& m) { return tabulated.pdf_visible(u, m) / m.z(); }));
      EXPECT_NEAR(total, 1, bound) << u.transpose();
    }
    EXPECT_GE(views, 10);
  }
}

TEST(Tabulated, RefusesWhatIsNoDistribution) {
  DiskTable table = make_disk_table({15, 0.6});
  EXPECT_THROW(Tabulated{table}, InputError);
  table.density(3, 3) = -1;
  EXPECT_THROW(Tabulated{table}, InputError);
  table.density(3, 3) = NAN;
  EXPECT_THROW(Tabulated{table}, InputError);
  table.density(3, 3) = INFINITY;
  EXPECT_THROW(Tabulated{table}, InputError);
}

// On the whole disk the estimate finds an ellipsoid's frame to the width of the table's steps, needles
// included.
TEST(Scatter, FindsTheFrame) {
  for (const EllipsoidParameters& p :
       {EllipsoidParameters{0.2, 0.2, 0, 0, 0}, {0.3, 0.02, 0, 0, 0.6}, {0.1, 0.05, 0.9, 0.2, 1}}) {
    const SlopeFrame frame = slope_frame(p);
    const DiskTable table = tabulate(Ellipsoid(frame), {513, 1});
    const SlopeFrame found = slope_scatter(core_nodes(table, 8192), table.grid);
    EXPECT_LE(frame.whiten(found.centre).norm(), 0.1);
    EXPECT_NEAR(found.l11 / frame.l11, 1, 0.2);
    EXPECT_NEAR(found.l22 / frame.l22, 1, 0.2);
    EXPECT_NEAR((found.l21 - frame.l21) / frame.l22, 0, 0.5);
  }
}

}  // namespace
}  // namespace micro
