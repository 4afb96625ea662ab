#include "kirchhoff/quadrature_lattice.h"

#include <gtest/gtest.h>

#include "height/triangles.h"
#include "testing/cosine_surface.h"

namespace micro {
namespace {

using testing::make_gaussian_surface;
using testing::with_missing;

/// Sums over a lattice of a function of (x, y, z).
struct Sums {
  double area = 0, flux = 0;
  Vec2 rim = Vec2::Zero();
};

template <typename Function>
Sums integrate(const HeightField& surface, int subdivision, Function&& f) {
  const QuadratureLattice lattice(surface, subdivision);
  LatticeRow row;
  Sums sums;
  for (std::int64_t l = 0; l < lattice.rows(); ++l) {
    lattice.fill(l, row);
    for (int i = 0; i < lattice.cols(); ++i) {
      const double x = i * lattice.dx(), y = static_cast<double>(l) * lattice.dy(), value = f(x, y, row.z[i]);
      sums.area += row.area[i] * value;
      sums.rim += Vec2(row.nx[i], row.ny[i]) * value;
    }
  }
  return sums;
}

TEST(QuadratureLattice, AreaIsTheProjectedArea) {
  for (const double missing : {0.0, 0.05, 0.6})
    for (const int subdivision : {1, 2, 3, 5}) {
      const HeightField surface =
          with_missing(make_gaussian_surface({.rows = 13, .cols = 17, .dx = 0.3}, 1), missing, 2);
      const Sums sums = integrate(surface, subdivision, [](double, double, double) { return 1; });
      EXPECT_NEAR(sums.area, projected_area(surface), 1e-5 * projected_area(surface));
      EXPECT_LE(sums.rim.norm(), 1e-5);  // closed curves
    }
}

TEST(QuadratureLattice, GaussTheoremHoldsForWhatItIntegratesExactly) {
  // f quadratic in (x, y) on each triangle: ∮ f n dl = ∫ ∇f dxdy, with z piecewise linear, f = z² + xz − y².
  const HeightField surface =
      with_missing(make_gaussian_surface({.rows = 12, .cols = 9, .dx = 0.3, .dy = 0.2}, 3), 0.1, 4);
  Vec2 gradient = Vec2::Zero();
  for (Eigen::Index j = 0; j + 1 < surface.rows(); ++j)
    for_each_triangle(surface, j, [&](const Triangle& t) {
      double x = 0, y = 0, z = 0;  // the gradient is linear: its mean is its value at the centroid
      for (const auto& corner : {t.a, t.b, t.c}) {
        x += corner.x() * surface.dx / 3;
        y += corner.y() * surface.dy / 3;
        z += surface.z(corner.y(), corner.x()) / 3.0;
      }
      const double area = surface.dx * surface.dy / 2;
      gradient += area * Vec2(2 * z * t.zx + z + x * t.zx, 2 * z * t.zy + x * t.zy - 2 * y);
    });
  for (const int subdivision : {1, 2, 3}) {
    const Sums sums =
        integrate(surface, subdivision, [](double x, double y, double z) { return z * z + x * z - y * y; });
    EXPECT_LE((sums.rim - gradient).norm(), 2e-5 * gradient.norm());
  }
}

TEST(QuadratureLattice, RowsOfSubVerticesCarryAreaOnOddColumnsOnly) {
  const HeightField surface = make_gaussian_surface({.rows = 6, .cols = 7}, 5);
  const QuadratureLattice lattice(surface, 2);
  LatticeRow row;
  for (std::int64_t l = 0; l < lattice.rows(); ++l) {
    lattice.fill(l, row);
    if (!QuadratureLattice::area_on_odd_columns_only(l)) continue;
    for (int i = 0; i < lattice.cols(); i += 2)
      EXPECT_EQ(row.area[i], 0);
  }
}

TEST(RimFraction, CountsEdges) {
  HeightField surface = make_gaussian_surface({.rows = 4, .cols = 5}, 6);
  // 12 cells: 15 + 16 straight edges and 12 diagonals, 14 of them on the rim.
  EXPECT_DOUBLE_EQ(rim_fraction(surface), 14.0 / 43);
  surface.z(0, 0) = kMissing;  // takes two triangles away: two rim edges and a diagonal go, two become rim
  EXPECT_DOUBLE_EQ(rim_fraction(surface), 14.0 / 40);
  surface.z.setConstant(kMissing);
  EXPECT_EQ(rim_fraction(surface), 0);
}

}  // namespace
}  // namespace micro
