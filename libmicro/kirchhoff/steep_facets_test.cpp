#include "kirchhoff/steep_facets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

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
    sum += std::polar<double>(point.area, -q.dot(Vec3(point.x, point.y, point.z)));
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

TEST(SteepFacets, IntegrateEveryFacetThatIsLeftOut) {
  const FacetPhases phases = {4 * M_PI / kLambdaQ, 1};
  for (const double height : {0.5, 3.0}) {
    const HeightField surface = cliffs(height);
    const auto points = steep_facet_points({surface, 1, {}, 0}, phases);
    const double area = 6 * 0.2 * 5 * 0.15;
    EXPECT_NEAR(sum_of(points, Vec3(0, 0, 0)).real(), area, 1e-6 * area);
    for (const Vec3& h : {Vec3(0, 0, 1), Vec3(0.6, -0.3, 0.7), Vec3(-0.1, 0.9, 0.4)}) {
      const Vec3 q = wave_vector(h.normalized(), kLambdaQ);
      EXPECT_LE(std::abs(sum_of(points, q) - literal_sum(surface, q, 400)), 1e-4 * area) << height;
    }
  }
}

TEST(SteepFacets, LeaveTheGentleOnesToTheLattice) {
  const HeightField surface = cliffs(3);
  const FacetPhases phases = {4 * M_PI / kLambdaQ, 1};
  const QuadratureLattice all(surface, 2), gentle(surface, 2, {}, 5);
  const auto steep = steep_facet_points(gentle, phases);
  LatticeRow row;
  double area = 0;
  for (std::int64_t l = 0; l < gentle.rows(); ++l) {
    gentle.fill(l, row);
    for (const float part : row.area)
      area += part;
  }
  EXPECT_GT(area, 0);
  EXPECT_GT(steep.size(), 0u);
  EXPECT_NEAR(area + sum_of(steep, Vec3(0, 0, 0)).real(), 6 * 0.2 * 5 * 0.15, 1e-6);
  EXPECT_TRUE(gentle.complete());
  EXPECT_TRUE(steep_facet_points(all, phases).empty());
  EXPECT_NEAR(static_cast<double>(count_facet_points(gentle, phases)), static_cast<double>(steep.size()),
              0.7 * static_cast<double>(steep.size()));
}

TEST(SteepFacets, OrdersGrowWithThePhase) {
  EXPECT_EQ(gauss_points(0), 2);
  EXPECT_LE(gauss_points(2.5), 4);
  EXPECT_LE(gauss_points(226), 70);
  EXPECT_GE(gauss_points(226), 57);  // half the phase is the least that resolves it
}

}  // namespace
}  // namespace micro
