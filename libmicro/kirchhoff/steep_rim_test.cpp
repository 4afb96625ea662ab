#include "kirchhoff/steep_rim.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <vector>

#include "kirchhoff/kirchhoff.h"
#include "testing/zoo.h"

namespace micro {
namespace {

using testing::grid_surface;
using Complex = std::complex<double>;
using Pair = std::array<Complex, 2>;

constexpr double kLambdaQ = 0.555, kDx = 0.2, kDy = 0.15;

/// Cliffs that meet the border and a hole; no edge is level.
HeightField cliffs(double height) {
  HeightField surface = grid_surface(6, 7, kDx, kDy, [height](auto j, auto i) {
    return height * (i > 3 ? static_cast<double>((i + j) % 2) : 0.0) +
           0.03 * static_cast<double>(i * i - 2 * j) + 0.01 * static_cast<double>(i * j);
  });
  surface.z(2, 4) = kMissing;
  return surface;
}

/// ∮ n e^{−iq·s} dl about every triangle in closed form: edges between two cancel.
Pair literal_sum(const HeightField& surface, const Vec3& q) {
  Pair sum = {};
  for (Eigen::Index row = 0; row + 1 < surface.rows(); ++row)
    for_each_triangle(surface, row, [&](const Triangle& t) {
      const auto place = [&](const Eigen::Vector2i& at) {
        return Vec3(at.x() * surface.dx, at.y() * surface.dy, surface.z(at.y(), at.x()));
      };
      const std::array<Vec3, 3> corner = {place(t.a), place(t.b), place(t.c)};
      const Vec3 u = corner[1] - corner[0], v = corner[2] - corner[0];
      const double sign = u.x() * v.y() - u.y() * v.x() > 0 ? 1 : -1;
      for (int k = 0; k < 3; ++k) {
        const Vec3 from = corner[k], to = corner[(k + 1) % 3];
        const double turn = q.dot(to - from);
        const Complex mean =
            std::polar(1.0, -q.dot(from)) * (Complex(1) - std::polar(1.0, -turn)) / Complex(0, turn);
        sum[0] += sign * (to.y() - from.y()) * mean;
        sum[1] -= sign * (to.x() - from.x()) * mean;
      }
    });
  return sum;
}

Pair sum_of(const std::array<std::vector<SurfacePoint>, 2>& points, const Vec3& q) {
  Pair sum = {};
  for (int axis = 0; axis < 2; ++axis)
    for (const SurfacePoint& point : points[axis])
      sum[axis] +=
          static_cast<double>(point.weight) * std::polar(1.0, -q.dot(Vec3(point.x, point.y, point.z)));
  return sum;
}

Pair sum_of(const QuadratureLattice& lattice, const Vec3& q) {
  Pair sum = {};
  LatticeRow row;
  for (std::int64_t l = 0; l < lattice.rows(); ++l) {
    lattice.fill(l, row);
    for (const int i : row.rim) {
      const Complex e =
          std::polar(1.0, -q.dot(Vec3(i * lattice.dx(), static_cast<double>(l) * lattice.dy(), row.z[i])));
      sum[0] += static_cast<double>(row.nx[i]) * e;
      sum[1] += static_cast<double>(row.ny[i]) * e;
    }
  }
  return sum;
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLength = 2 * (6 * kDx + 5 * kDy) + 8 * kDx;  // of border and hole, about

const std::vector<Vec3> kDirections = {{0, 0.01, 1}, {0.6, -0.3, 0.7}, {-0.1, 0.9, 0.4}};

TEST(SteepRim, IntegratesEveryEdgeThatIsLeftOut) {
  const FacetPhases phases = {4 * M_PI / kLambdaQ, 1, 1e-7};
  for (const double height : {0.5, 3.0, 60.0}) {
    const HeightField surface = cliffs(height);
    const QuadratureLattice none(surface, 1, {}, kInfinity, 0);
    const SteepRim rim = find_steep_rim(none, phases);
    const auto points = rim_points(none, rim, phases);
    EXPECT_EQ(static_cast<std::int64_t>(points[0].size() + points[1].size()), rim.points);
    for (const Vec3& h : kDirections) {
      const Vec3 q = wave_vector(h.normalized(), kLambdaQ);
      const Pair got = sum_of(points, q), wanted = literal_sum(surface, q), lattice = sum_of(none, q);
      for (int axis = 0; axis < 2; ++axis) {
        // Weights are single precision numbers.
        EXPECT_LE(std::abs(got[axis] - wanted[axis]), 1e-6 * kLength) << height;
        EXPECT_EQ(lattice[axis], Complex(0));
      }
    }
  }
}

TEST(SteepRim, LeavesTheGentleOnesToTheLattice) {
  const HeightField surface = cliffs(3);
  const FacetPhases phases = {4 * M_PI / kLambdaQ, 1};
  const QuadratureLattice all(surface, 16), gentle(surface, 16, {}, kInfinity, 1);
  EXPECT_EQ(find_steep_rim(all, phases).points, 0);
  const SteepRim rim = find_steep_rim(gentle, phases);
  const auto points = rim_points(gentle, rim, phases);
  EXPECT_GT(rim.edges.size(), 4u);
  for (const Vec3& h : kDirections) {
    const Vec3 q = wave_vector(h.normalized(), kLambdaQ);
    const Pair steep = sum_of(points, q), lattice = sum_of(gentle, q), wanted = literal_sum(surface, q);
    for (int axis = 0; axis < 2; ++axis) {
      EXPECT_LE(std::abs(steep[axis] + lattice[axis] - wanted[axis]), 2e-5 * kLength);
      EXPECT_GT(std::abs(lattice[axis]), 1e-3 * kLength);
    }
  }
}

}  // namespace
}  // namespace micro
