#include "kirchhoff/steep_facets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <vector>

#include "kirchhoff/kirchhoff.h"
#include "testing/zoo.h"

namespace micro {
namespace {

using testing::grid_surface;
using Complex = std::complex<double>;

constexpr double kLambdaQ = 0.555;

/// A gentle slope and, from the fourth column on, a checkerboard of cliffs; no two corners at one height.
HeightField cliffs(double height) {
  return grid_surface(6, 7, 0.2, 0.15, [height](auto j, auto i) {
    return height * (i > 3 ? static_cast<double>((i + j) % 2) : 0.0) +
           0.03 * static_cast<double>(i * i - 2 * j);
  });
}

/// Σ area·e^{−iq·s}.
Complex sum_of(const std::vector<SurfacePoint>& points, const Vec3& q) {
  Complex sum = 0;
  for (const SurfacePoint& point : points)
    sum += std::polar<double>(point.weight, -q.dot(Vec3(point.x, point.y, point.z)));
  return sum;
}

/// ∫e^{−iq·s} dxdy over the whole surface by the midpoint rule on cuts² equal triangles of each.
Complex literal_sum(const HeightField& surface, const Vec3& q, int cuts) {
  Complex sum = 0;
  for (Eigen::Index row = 0; row + 1 < surface.rows(); ++row)
    for_each_triangle(surface, row, [&](const Triangle& t) {
      const auto place = [&](const Eigen::Vector2i& at) {
        return Vec3(at.x() * surface.dx, at.y() * surface.dy, surface.z(at.y(), at.x()));
      };
      const Vec3 a = place(t.a), u = (place(t.b) - a) / cuts, v = (place(t.c) - a) / cuts;
      const double area = surface.dx * surface.dy / 2 / cuts / cuts;
      for (int j = 0; j < cuts; ++j)
        for (int i = 0; i + j < cuts; ++i) {
          sum += std::polar(area, -q.dot(a + (i + 1 / 3.) * u + (j + 1 / 3.) * v));
          if (i + j + 1 < cuts) sum += std::polar(area, -q.dot(a + (i + 2 / 3.) * u + (j + 2 / 3.) * v));
        }
    });
  return sum;
}

std::vector<SurfacePoint> points_of(const QuadratureLattice& lattice, const FacetPhases& phases) {
  const SteepFacets steep = find_steep_facets(lattice, phases);
  auto points = facet_points(lattice, steep, phases);
  EXPECT_EQ(static_cast<std::int64_t>(points.size()), steep.points());
  return points;
}

constexpr double kArea = 6 * 0.2 * 5 * 0.15;
/// FacetPhases::tolerance.
constexpr double kRule = 1e-5;

TEST(SteepFacets, IntegrateEveryFacetThatIsLeftOut) {
  const FacetPhases phases = {4 * M_PI / kLambdaQ, 1};
  for (const double height : {0.5, 3.0}) {
    const HeightField surface = cliffs(height);
    const auto points = points_of({surface, 1, {}, 0}, phases);
    // Areas are single precision numbers.
    EXPECT_NEAR(sum_of(points, Vec3(0, 0, 0)).real(), kArea, 1e-6 * kArea);
    for (const Vec3& h : {Vec3(0, 0, 1), Vec3(0.6, -0.3, 0.7), Vec3(-0.1, 0.9, 0.4)}) {
      const Vec3 q = wave_vector(h.normalized(), kLambdaQ);
      // The midpoint rule errs by the square of its steps: Richardson's two add up to the fourth power.
      const Complex coarse = literal_sum(surface, q, 60), fine = literal_sum(surface, q, 120);
      EXPECT_LE(std::abs(sum_of(points, q) - (4. * fine - coarse) / 3.), kRule * kArea) << height;
    }
  }
}

/// ∫e^{−iq·s} dxdy over a triangle in closed form: Σ over its corners of e^{−iφ_k}/((φ_k − φ_l)(φ_k − φ_m)).
Complex closed_form(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& q) {
  using Long = std::complex<long double>;
  const Vec3 u = b - a, v = c - a;
  const long double phase[3] = {q.dot(a), q.dot(b), q.dot(c)};
  Long sum = 0;
  for (int k = 0; k < 3; ++k)
    sum += std::polar(1.L, -phase[k]) / ((phase[k] - phase[(k + 1) % 3]) * (phase[k] - phase[(k + 2) % 3]));
  return Complex(sum * Long(-std::abs(u.x() * v.y() - u.y() * v.x())));
}

// The phase along a cliff of a millimetre turns by 22,000 rad: a single rule would take seconds to make.
TEST(SteepFacets, CutAMillimetreIntoPanels) {
  const double height = 1000;
  const HeightField cliff = grid_surface(2, 2, 0.2, 0.15, [height](auto j, auto i) {
    return i == 1 && j == 0 ? height : 0.1 * static_cast<double>(i + 2 * j);
  });
  const FacetPhases phases = {4 * M_PI / kLambdaQ, 1};
  const auto points = points_of({cliff, 1, {}, 0}, phases);
  EXPECT_GT(points.size(), 10'000u);
  const auto place = [&](int j, int i) { return Vec3(0.2 * i, 0.15 * j, cliff.z(j, i)); };
  for (const Vec3& h : {Vec3(0, 0, 1), Vec3(0.6, -0.3, 0.7), Vec3(0.9, 0.3, 1e-4)}) {
    const Vec3 q = wave_vector(h.normalized(), kLambdaQ);
    const Complex wanted = closed_form(place(0, 0), place(0, 1), place(1, 1), q) +
                           closed_form(place(0, 0), place(1, 1), place(1, 0), q);
    // Heights of a millimetre are single precision numbers, 6e-5 µm apart.
    const double rounding = 3e-5 * std::abs(q.z());
    EXPECT_LE(std::abs(sum_of(points, q) - wanted), (kRule + rounding) * 0.2 * 0.15) << h;
  }
}

TEST(SteepFacets, CountWhatNoMemoryHolds) {
  const HeightField cliff =
      grid_surface(2, 2, 1e6, 1e6, [](auto j, auto i) { return i == 1 && j == 0 ? 1e30 : 0.; });
  const FacetPhases phases = {4 * M_PI / kLambdaQ, 1};
  EXPECT_GT(find_steep_facets({cliff, 1, {}, 0}, phases).points(), std::int64_t{1} << 40);
}

TEST(SteepFacets, LeaveTheGentleOnesToTheLattice) {
  const HeightField surface = cliffs(3);
  const FacetPhases phases = {4 * M_PI / kLambdaQ, 1};
  const QuadratureLattice all(surface, 2), gentle(surface, 2, {}, 5);
  const auto steep = points_of(gentle, phases);
  LatticeRow row;
  double area = 0;
  for (std::int64_t l = 0; l < gentle.rows(); ++l) {
    gentle.fill(l, row);
    for (const float part : row.area)
      area += part;
  }
  EXPECT_GT(area, 0);
  EXPECT_GT(steep.size(), 0u);
  EXPECT_NEAR(area + sum_of(steep, Vec3(0, 0, 0)).real(), kArea, 1e-6 * kArea);
  EXPECT_TRUE(gentle.complete());
  EXPECT_TRUE(points_of(all, phases).empty());
}

TEST(SteepFacets, TakeAsManyPointsAsExpected) {
  // Where a facet's middle corner lies is not known beforehand: within a factor of two.
  const FacetPhases phases = {4 * M_PI / kLambdaQ, 1};
  for (const double height : {0.5, 3.0, 30.0}) {
    const HeightField surface = cliffs(height);
    const QuadratureLattice lattice(surface, 1, {}, 0);
    double expected = 0;
    for (const Triangle& t : find_steep_facets(lattice, phases).facets)
      expected += expected_facet_points(std::hypot(t.zx, t.zy), 0.2, phases);
    const auto points = static_cast<double>(points_of(lattice, phases).size());
    EXPECT_GT(expected, points / 2) << height;
    EXPECT_LT(expected, points * 2) << height;
  }
}

}  // namespace
}  // namespace micro
