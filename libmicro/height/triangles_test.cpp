#include "height/triangles.h"

#include <gtest/gtest.h>

namespace micro {
namespace {

TEST(Triangles, AreaIsThatOfTheCompleteGrid) {
  const HeightField plane = make_height_field(Grid<double>::Zero(4, 6), 0.5, 2);
  EXPECT_EQ(triangle_count(plane), 2 * 3 * 5);
  EXPECT_DOUBLE_EQ(projected_area(plane), 3 * 5 * 0.5 * 2);
}

TEST(Triangles, AMissingCornerTakesItsSixTriangles) {
  Grid<double> z = Grid<double>::Zero(5, 5);
  z(2, 2) = kMissing;
  EXPECT_EQ(triangle_count(make_height_field(z, 1, 1)), 2 * 16 - 6);
}

TEST(Triangles, SlopesOfATiltedPlane) {
  Grid<double> z(3, 4);
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 4; ++i)
      z(j, i) = 0.3 * (i * 0.5) - 0.2 * (j * 2.0);
  const HeightField plane = make_height_field(z, 0.5, 2);
  for (int j = 0; j < 2; ++j)
    for_each_triangle(plane, j, [](const Triangle& t) {
      EXPECT_NEAR(t.zx, 0.3, 1e-6);
      EXPECT_NEAR(t.zy, -0.2, 1e-6);
      const Eigen::Vector2i u = t.b - t.a, v = t.c - t.a;
      EXPECT_EQ(u.x() * v.y() - u.y() * v.x(), 1);  // anticlockwise
    });
}

}  // namespace
}  // namespace micro
