#include "distribution/slope_coordinates.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <unsupported/Eigen/MatrixFunctions>

#include "core/random.h"

namespace micro {
namespace {

/// Eigen's general matrix logarithm loses digits as the widths' ratio squared.
constexpr double kMatrixLog = 1e-9;
constexpr double kRoundTrip = 1e-12;

TEST(SlopeCoordinates, AreHalfTheLogarithmOfTheScale) {
  for (std::uint64_t k = 0; k < 200; ++k) {
    const auto [a, b] = random_uniform(1, 0, k);
    const auto [c, d] = random_uniform(1, 1, k);
    const SlopeFrame frame = {{a - 0.5, b}, 0.01 + c, d - 0.5, 0.01 + a};
    const Eigen::Matrix2d scale = frame.scale(), half = scale.log() / 2;
    const SlopeCoordinates p = slope_coordinates(frame);
    EXPECT_NEAR(p[0], frame.centre.x(), 0);
    EXPECT_NEAR(p[1], frame.centre.y(), 0);
    EXPECT_NEAR(p[2], half(0, 0), kMatrixLog);
    EXPECT_NEAR(p[3], half(0, 1), kMatrixLog);
    EXPECT_NEAR(p[4], half(1, 1), kMatrixLog);
  }
}

TEST(SlopeCoordinates, GoBothWays) {
  for (std::uint64_t k = 0; k < 500; ++k) {
    const auto [a, b] = random_uniform(2, 0, k);
    const auto [c, d] = random_uniform(2, 1, k);
    const double narrow = std::pow(10, -6 * a), wide = narrow * std::pow(10, 4 * b);
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(10 * c).toRotationMatrix();
    const double middle = std::log(wide * narrow) / 2, spread = std::log(wide / narrow) / 2;
    const Eigen::Matrix2d half =
        turn * Eigen::Vector2d(middle + spread, middle - spread).asDiagonal() * turn.transpose();
    const SlopeCoordinates p = {d, -d, half(0, 0), half(0, 1), half(1, 1)};
    const SlopeCoordinates again = slope_coordinates(frame_of(p));
    for (std::size_t n = 0; n < 5; ++n)
      EXPECT_NEAR(again[n], p[n], kRoundTrip * 1e3 * (1 + std::abs(p[n]))) << "case " << k << " number " << n;
  }
}

TEST(SlopeCoordinates, AreALobeWhateverTheNumbers) {
  for (const double a : {-1e6, -50., 0., 50., 1e6})
    for (const double b : {-1e6, -3., 0., 1e-300, 1e6}) {
      const SlopeFrame frame = frame_of({0, 0, a, b, -a});
      EXPECT_TRUE(std::isfinite(frame.l11) && std::isfinite(frame.l21) && std::isfinite(frame.l22));
      EXPECT_GT(static_cast<float>(frame.l11), 0);
      EXPECT_GT(static_cast<float>(frame.l22), 0);
    }
}

}  // namespace
}  // namespace micro
