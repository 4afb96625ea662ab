#include "distribution/directions.h"

#include <gtest/gtest.h>

#include "core/error.h"

namespace micro {
namespace {

TEST(Directions, CoverTheDiskEvenly) {
  constexpr int kCount = 20000;
  for (const double extent : {1.0, 0.2}) {
    const auto h = spread_directions(kCount, extent);
    ASSERT_EQ(h.size(), static_cast<std::size_t>(kCount));
    double xx = 0, yy = 0, x = 0, inside = 0;
    for (const Vec3& d : h) {
      EXPECT_NEAR(d.norm(), 1, 1e-15);
      EXPECT_GT(d.z(), 0);
      EXPECT_LT(std::hypot(d.x(), d.y()), extent);
      x += d.x();
      xx += d.x() * d.x();
      yy += d.y() * d.y();
      inside += d.x() > 0 && d.y() > 0 && std::hypot(d.x(), d.y()) < extent / 2;
    }
    // Moments of the uniform disk, r²/4, and the share of a quarter of the half-size disk, 1/16.
    EXPECT_NEAR(x / kCount / extent, 0, 1e-3);
    EXPECT_NEAR(xx / kCount / (extent * extent), 0.25, 1e-3);
    EXPECT_NEAR(yy / kCount / (extent * extent), 0.25, 1e-3);
    EXPECT_NEAR(inside / kCount, 1.0 / 16, 2e-3);
  }
}

TEST(Directions, RefusesWithAReason) {
  EXPECT_EQ(spread_directions(1).size(), 1u);
  EXPECT_THROW(spread_directions(0), InputError);
  EXPECT_THROW(spread_directions(5, 0), InputError);
  EXPECT_THROW(spread_directions(5, 1.01), InputError);
  EXPECT_THROW(spread_directions(5, std::nan("")), InputError);
}

}  // namespace
}  // namespace micro
