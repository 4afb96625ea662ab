#include "ndf/truncation.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "ndf/local_planes.h"

namespace micro {
namespace {

constexpr double kPitch = 0.5, kSigma = 1;

/// A bound that is more than this many times what happens says nothing. The bound is that of the worst
/// window, at a corner of the surface, whose variances are a tenth of a complete window's.
constexpr double kSlack = 1000;

/// Heights ±1 µm far from the middle, 0 elsewhere: all that the middle's window cuts away, and nothing else.
enum class Far { AlongX, AlongY };
HeightField far_heights(int rows, int cols, Far far) {
  Grid<double> z(rows, cols);
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < cols; ++i) {
      const double x = (i - cols / 2) * kPitch / kSigma, y = (j - rows / 2) * kPitch / kSigma;
      const bool beyond = std::abs(far == Far::AlongX ? x : y) > 7;
      z(j, i) = beyond ? (far == Far::AlongX ? std::copysign(1., x) : std::copysign(1., x * y)) : 0;
    }
  return make_height_field(z, kPitch, kPitch);
}

/// Slopes at the middle by the uncut definition in long double: the mask is symmetric, so ⟨xz⟩/⟨x²⟩.
std::pair<double, double> uncut_slopes(const HeightField& surface) {
  long double xz = 0, yz = 0, xx = 0, yy = 0;
  for (Eigen::Index j = 0; j < surface.rows(); ++j)
    for (Eigen::Index i = 0; i < surface.cols(); ++i) {
      const long double x = static_cast<long double>(i - surface.cols() / 2) * kPitch;
      const long double y = static_cast<long double>(j - surface.rows() / 2) * kPitch;
      const long double w = std::exp(-(x * x + y * y) / 2);
      const auto z = static_cast<long double>(surface.z(j, i));
      xz += w * x * z, yz += w * y * z, xx += w * x * x, yy += w * y * y;
    }
  return {static_cast<double>(xz / xx), static_cast<double>(yz / yy)};
}

TEST(Truncation, TheBoundHoldsAndIsNotFarOff) {
  for (const Far far : {Far::AlongX, Far::AlongY}) {
    const HeightField surface = far_heights(41, 43, far);
    const SlopeField slopes = local_planes(surface, kSigma);
    const auto [zx, zy] = uncut_slopes(surface);
    const double error = std::max(std::abs(slopes.zx(20, 21) - zx), std::abs(slopes.zy(20, 21) - zy));
    EXPECT_GT(error, 1e-14) << "the window's cut is to be seen";
    EXPECT_LE(error, slopes.truncation_error);
    EXPECT_LE(slopes.truncation_error, kSlack * error);
  }
}

// Where the surface is long along y alone, only the cut in y counts: it must not be forgotten.
TEST(Truncation, EitherAxisAloneCounts) {
  const HeightField tall = far_heights(41, 9, Far::AlongY);
  const HeightField wide = far_heights(9, 41, Far::AlongX);
  EXPECT_GT(local_planes(tall, kSigma).truncation_error, 1e-12);
  EXPECT_GT(local_planes(wide, kSigma).truncation_error, 1e-12);
  EXPECT_EQ(local_planes(far_heights(9, 9, Far::AlongX), kSigma).truncation_error, 0) << "nothing is cut";
}

TEST(Truncation, GrowsWithTheHeights) {
  HeightField surface = far_heights(41, 41, Far::AlongX);
  const double bound = slope_truncation_bound(surface, kSigma, {.zx = 0.1, .zy = 0.2});
  surface.z *= 4;
  EXPECT_NEAR(slope_truncation_bound(surface, kSigma, {.zx = 0.4, .zy = 0.8}) / bound, 4, 1e-6);
  EXPECT_EQ(slope_truncation_bound(make_height_field(Grid<double>(1, 1), 1, 1), 5, {}), 0);
}

}  // namespace
}  // namespace micro
