#include "brdf/half_angle_table.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "brdf/any_brdf.h"
#include "brdf/microfacet.h"
#include "distribution/ellipsoid.h"

namespace micro {
namespace {

constexpr double kRounding = 1e-14;

/// A bin's directions have the bin's angles: [Rusinkiewicz98]'s own definition, rotated back.
TEST(HalfAngleTables, DirectionsHaveTheirAngles) {
  HalfAngleGrid grid{7, 5, 9, 0.4};
  for (std::int64_t i = 0; i < 7; ++i)
    for (std::int64_t j = 0; j < 5; ++j)
      for (std::int64_t k = 0; k < 9; ++k) {
        const auto [wi, wo] = grid.directions(i, j, k);
        const Vec3 h = half_vector(wi, wo);
        EXPECT_NEAR(std::acos(h.z()), grid.theta_h_at(i), 1e-7);
        EXPECT_NEAR(wi.dot(h), std::cos(grid.theta_d_at(j)), kRounding);
        EXPECT_NEAR(std::atan2(h.y(), h.x()), 0.4, 1e-12);
        const Vec3 turned = Eigen::AngleAxisd(-grid.theta_h_at(i), Vec3::UnitY()) *
                            (Eigen::AngleAxisd(-0.4, Vec3::UnitZ()) * wi);
        EXPECT_NEAR(std::atan2(turned.y(), turned.x()), grid.phi_d_at(k), 1e-12);
      }
}

TEST(HalfAngleTables, HoldTheModel) {
  const AnyBrdf model(Microfacet(ggx(0.3), Fresnel(std::complex(0.2, 3.))));
  const HalfAngleGrid grid{6, 6, 4, 0};
  const auto table = half_angle_table(model, {0.5, 0.6}, grid);
  ASSERT_EQ(table.size(), 2u * 144u);
  const auto [wi, wo] = grid.directions(2, 3, 1);
  EXPECT_EQ(table[144 + (2 * 6 + 3) * 4 + 1], static_cast<float>(model.f(wi, wo, 0.6)));
  EXPECT_EQ(table[(5 * 6 + 5) * 4], 0);  // wo is below the horizon there
}

}  // namespace
}  // namespace micro
