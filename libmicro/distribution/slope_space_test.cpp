#include "distribution/slope_space.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numbers>

#include "core/error.h"
#include "core/random.h"

namespace micro {
namespace {

constexpr double kPi = std::numbers::pi;

/// Parameters of all shapes: widths 1e-4…10, any angles.
EllipsoidParameters random_parameters(std::uint64_t k) {
  const auto [a, b] = random_uniform(1, 0, k);
  const auto [x, y] = random_uniform(1, 1, k);
  const double z = random_uniform(1, 2, k)[0];
  return {std::pow(10, 5 * a - 4), std::pow(10, 5 * b - 4), kPi * (2 * x - 1), kPi * (2 * y - 1),
          kPi * (2 * z - 1)};
}

/// How far apart two frames are in units of the first one's width.
double distance(const SlopeFrame& a, const SlopeFrame& b) {
  return std::max({a.whiten(b.centre).norm(), std::abs(b.l11 / a.l11 - 1), std::abs(b.l22 / a.l22 - 1),
                   std::abs(b.l21 - a.l21) / a.l22});
}

TEST(SlopeSpace, CentreAndScaleAreThoseOfTheInverseMatrix) {
  for (std::uint64_t k = 0; k < 200; ++k) {
    EllipsoidParameters p = random_parameters(k);
    p.alpha_x = 0.1 + 0.9 * random_uniform(2, 0, k)[0];  // mild, so that the textbook inverse is accurate
    p.alpha_y = 0.1 + 0.9 * random_uniform(2, 0, k)[1];
    const double cx = std::cos(p.theta_x), sx = std::sin(p.theta_x), cy = std::cos(p.theta_y),
                 sy = std::sin(p.theta_y), cz = std::cos(p.theta_z), sz = std::sin(p.theta_z);
    const Eigen::Matrix3d rx = (Eigen::Matrix3d() << 1, 0, 0, 0, cx, -sx, 0, sx, cx).finished(),
                          ry = (Eigen::Matrix3d() << cy, 0, sy, 0, 1, 0, -sy, 0, cy).finished(),
                          rz = (Eigen::Matrix3d() << cz, -sz, 0, sz, cz, 0, 0, 0, 1).finished();
    const Eigen::Matrix3d a = Vec3(p.alpha_x, p.alpha_y, 1).asDiagonal() * (rx * ry * rz);
    const Eigen::Matrix3d c = (a.transpose() * a).inverse();
    const Eigen::Matrix2d inverse = c.topLeftCorner<2, 2>().inverse();
    const Vec2 centre = inverse * c.topRightCorner<2, 1>();
    const Eigen::Matrix2d scale = inverse / a.col(2).squaredNorm();
    constexpr double kInverse = 1e-8;  // the textbook inverse's own conditioning
    const SlopeFrame frame = slope_frame(p);
    EXPECT_LE((frame.centre - centre).norm(), kInverse * (1 + centre.norm()));
    EXPECT_LE((frame.scale() - scale).norm(), kInverse * scale.norm());
  }
}

TEST(SlopeSpace, WithoutTiltTheScaleIsAlpha) {
  const SlopeFrame frame = slope_frame({0.3, 0.1, 0, 0, 0});
  EXPECT_DOUBLE_EQ(frame.l11, 0.3);
  EXPECT_DOUBLE_EQ(frame.l22, 0.1);
  EXPECT_EQ(frame.l21, 0);
  EXPECT_EQ(frame.centre.norm(), 0);
}

// A small tilt moves the peak of the distribution, the slope t, by the angle.
TEST(SlopeSpace, ThetaTiltsThePeak) {
  const double tilt = 1e-3;
  const Vec2 about_x = slope_frame({0.01, 0.01, tilt, 0, 0}).centre,
             about_y = slope_frame({0.01, 0.01, 0, tilt, 0}).centre;
  EXPECT_NEAR(about_x.norm(), tilt, 1e-3 * tilt);
  EXPECT_NEAR(about_y.norm(), tilt, 1e-3 * tilt);
  EXPECT_NEAR(about_x.dot(about_y), 0, 1e-12);
}

TEST(SlopeSpace, CanonicalParametersMakeTheSameDistribution) {
  constexpr double kRoundTrip = 1e-7;  // in widths; tilts of 1e5 widths lose as many digits
  for (std::uint64_t k = 0; k < 3000; ++k) {
    const SlopeFrame frame = slope_frame(random_parameters(k));
    if (!(frame.centre.norm() < 1e4)) continue;  // beyond a slope of 1e4 the angle itself has too few digits
    const EllipsoidParameters p = canonical_parameters(frame);
    EXPECT_GE(p.alpha_x, p.alpha_y);
    EXPECT_GT(p.theta_z, -kPi / 2);
    EXPECT_LE(p.theta_z, kPi / 2);
    EXPECT_LE(std::abs(p.theta_x), kPi / 2);
    EXPECT_LE(std::abs(p.theta_y), kPi / 2);
    const SlopeFrame again = slope_frame(p);
    const double condition = 1 + frame.centre.norm() * (1 + frame.centre.norm()) / std::min(frame.l22, 1.);
    EXPECT_LE(distance(frame, again), kRoundTrip + 1e-14 * condition)
        << k << ": " << p.alpha_x << " " << p.alpha_y << " " << p.theta_x << " " << p.theta_y;
  }
}

TEST(SlopeSpace, CanonicalParametersOfSmallTiltsAreTheOnesGiven) {
  for (std::uint64_t k = 0; k < 300; ++k) {
    const auto [a, b] = random_uniform(3, 0, k);
    const auto [x, y] = random_uniform(3, 1, k);
    EllipsoidParameters p = {0.05 + 0.4 * a, 0, 0.5 * (x - 0.5), 0.5 * (y - 0.5),
                             kPi * (random_uniform(3, 2, k)[0] - 0.5)};
    p.alpha_y = p.alpha_x * (0.1 + 0.8 * b);
    const EllipsoidParameters q = canonical_parameters(slope_frame(p));
    constexpr double kSame = 1e-11;
    EXPECT_NEAR(q.alpha_x, p.alpha_x, kSame);
    EXPECT_NEAR(q.alpha_y, p.alpha_y, kSame);
    EXPECT_NEAR(q.theta_x, p.theta_x, kSame);
    EXPECT_NEAR(q.theta_y, p.theta_y, kSame);
    EXPECT_NEAR(q.theta_z, p.theta_z, kSame);
  }
}

TEST(SlopeSpace, RoundLobesHaveNoThirdAngle) {
  for (const double theta : {0., 0.2, -0.7}) {
    const EllipsoidParameters p = canonical_parameters(slope_frame({0.2, 0.2, theta, 0.3, 1.1}));
    EXPECT_EQ(p.theta_z, 0);
    EXPECT_NEAR(p.alpha_x, 0.2, 1e-12);
    EXPECT_NEAR(p.alpha_y, 0.2, 1e-12);
    const double distance_of = distance(slope_frame(p), slope_frame({0.2, 0.2, theta, 0.3, 1.1}));
    EXPECT_LE(distance_of, 1e-11);
  }
  EXPECT_NEAR(std::abs(canonical_parameters(slope_frame({0.2, 0.1, 0, 0, kPi / 2})).theta_z), kPi / 2, 1e-15);
}

// Of equal axes one may be turned towards n, so its own axis is the third of a round lobe up to 54.7° and can
// no longer be beyond. The distribution and its place in slope space do not jump.
TEST(SlopeSpace, RoundLobesAreWrittenByAnotherAxisBeyondTheirLargestTilt) {
  constexpr double kDegree = kPi / 180, kSame = 1e-9;
  const SlopeFrame below = slope_frame({0.2, 0.2, 0, 54 * kDegree, 0}),
                   beyond = slope_frame({0.2, 0.2, 0, 55 * kDegree, 0});
  const EllipsoidParameters near = canonical_parameters(below), far = canonical_parameters(beyond);
  EXPECT_NEAR(near.alpha_x, 0.2, kSame);
  EXPECT_NEAR(near.alpha_y, 0.2, kSame);
  EXPECT_NEAR(near.theta_y, 54 * kDegree, kSame);
  EXPECT_NEAR(far.alpha_x, 5, kSame);
  EXPECT_NEAR(far.alpha_y, 1, kSame);
  EXPECT_EQ(far.theta_x, 0);
  EXPECT_NEAR(far.theta_y, -35 * kDegree, kSame);
  EXPECT_LE(distance(slope_frame(far), beyond), kSame);
  EXPECT_LE(distance(below, beyond), 0.5);
}

TEST(SlopeSpace, RefusesWhatIsNoEllipsoid) {
  EXPECT_THROW(slope_frame({0, 0.1, 0, 0, 0}), InputError);
  EXPECT_THROW(slope_frame({0.1, -0.1, 0, 0, 0}), InputError);
  EXPECT_THROW(slope_frame({0.1, 0.1, NAN, 0, 0}), InputError);
  EXPECT_THROW(slope_frame({INFINITY, 0.1, 0, 0, 0}), InputError);
}

}  // namespace
}  // namespace micro
