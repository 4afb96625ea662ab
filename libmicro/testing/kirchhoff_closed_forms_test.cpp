#include "testing/kirchhoff_closed_forms.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "kirchhoff/exact.h"

namespace micro::testing {
namespace {

/// Heights are stored as float: their rounding moves phases by q_z·6e-8·|z|.
constexpr double kFloatHeights = 1e-5;

std::vector<Vec3> directions() {
  std::vector<Vec3> q;
  for (const Vec2& h : {Vec2(0, 0), Vec2(0.2, 0), Vec2(-0.35, 0.03), Vec2(0.6, -0.3), Vec2(0.95, 0.1)})
    q.push_back(wave_vector({h.x(), h.y(), std::sqrt(1 - h.squaredNorm())}, 0.555));
  return q;
}

/// cols × rows heights of profile z(x); the mean that make_height_field removes only turns the phase.
template <typename Profile>
HeightField ruled(Eigen::Index rows, Eigen::Index cols, double dx, double dy, Profile&& profile) {
  Grid<double> z(rows, cols);
  for (Eigen::Index i = 0; i < cols; ++i)
    z.col(i).setConstant(profile(static_cast<double>(i) * dx));
  return make_height_field(z, dx, dy);
}

TEST(KirchhoffClosedForms, PlateIsExact) {
  const double dx = 0.25, dy = 0.125;
  const Vec2 slope(0.5, -0.25);
  Grid<double> z(33, 41);
  for (Eigen::Index j = 0; j < z.rows(); ++j)
    for (Eigen::Index i = 0; i < z.cols(); ++i)
      z(j, i) = slope.x() * dx * static_cast<double>(i) + slope.y() * dy * static_cast<double>(j);
  const HeightField surface = make_height_field(z, dx, dy);
  const Rectangle patch{40 * dx, 32 * dy};
  for (const Vec3& q : directions()) {
    const double expected = std::abs(plate_field(patch, slope, q));
    EXPECT_NEAR(std::abs(exact_field(surface, q)), expected,
                1e-10 * q.norm() * patch.length_x * patch.length_y);
  }
}

TEST(KirchhoffClosedForms, TwoLevelGratingIsExactAndItsOrdersStandWhereThePitchSays) {
  const double dx = 0.1, period = 2, depth = 0.140;
  const auto level = [&](double x) { return std::fmod(x + 1e-9, period) < period / 2 ? depth : 0.0; };
  const HeightField surface = ruled(41, 401, dx, 0.1, level);
  const Rectangle patch{40, 4};
  std::vector<double> heights(static_cast<std::size_t>(surface.cols()));
  for (std::size_t i = 0; i < heights.size(); ++i)
    heights[i] = surface.z(0, static_cast<Eigen::Index>(i));
  for (const Vec3& q : directions()) {
    const double expected = std::abs(profile_field(patch, heights, q));
    EXPECT_NEAR(std::abs(exact_field(surface, q)), expected, 1e-10 * q.norm() * 160);
  }
  // Orders q_x = 2πn/p; D between them is the tail of 20 periods' sinc².
  const double k = 4 * std::numbers::pi / 0.555, order = 2 * std::numbers::pi / period;
  const auto density = [&](double n) {
    const double qx = n * order;
    return exact_density(surface, {qx, 0, std::sqrt(k * k - qx * qx)});
  };
  for (const double n : {-3.0, -1.0, 1.0, 3.0}) {
    EXPECT_GT(density(n), 20 * density(n + 0.5)) << n;
    EXPECT_GT(density(n), density(n + 0.03)) << n;
    EXPECT_GT(density(n), density(n - 0.03)) << n;
  }
}

// The triangulated sinusoid is O(pitch²) away from the smooth one: the error falls fourfold when the pitch is
// halved, and what Richardson extrapolation leaves is far smaller.
TEST(KirchhoffClosedForms, SinusoidIsTheLimitOfFinePitch) {
  const double amplitude = 0.2, wave_number = 2 * std::numbers::pi / 3.3, phase = 0.4;
  const Rectangle patch{12, 2};
  for (const Vec3& q : directions()) {
    const std::complex<double> smooth = sinusoid_field(patch, amplitude, wave_number, phase, q);
    const double scale = q.norm() * patch.length_x * patch.length_y / std::sqrt(40.0);
    std::vector<std::complex<double>> field;
    for (const Eigen::Index cells : {240, 480}) {
      const double dx = patch.length_x / static_cast<double>(cells);
      const HeightField surface = ruled(
          5, cells + 1, dx, 0.5, [&](double x) { return amplitude * std::cos(wave_number * x + phase); });
      field.push_back(exact_field(surface, q) * std::polar(1.0, -q.z() * surface.mean));
    }
    const double coarse = std::abs(field[0] - smooth), fine = std::abs(field[1] - smooth);
    EXPECT_LE(coarse, 0.03 * scale);
    EXPECT_LE(std::abs(coarse - 4 * fine), 0.1 * coarse + kFloatHeights * scale);
    EXPECT_LE(std::abs((4.0 * field[1] - field[0]) / 3.0 - smooth), 0.03 * coarse + kFloatHeights * scale);
  }
}

}  // namespace
}  // namespace micro::testing
