#include "ndf/local_planes.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numbers>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"

namespace micro {
namespace {

/// [issue: ≤ 1e-9 in slope times the fit's condition]
constexpr double kSlopeTolerance = 1e-9;

struct LiteralFit {
  double zx, zy, condition;
};

/// The definition, term by term: every valid point of the surface, weighted, in one QR solve.
LiteralFit literal_fit(const HeightField& surface, double sigma, Eigen::Index row, Eigen::Index col) {
  const Eigen::Index n = surface.z.size() - missing_count(surface);
  Eigen::MatrixXd design(n, 3);
  Eigen::VectorXd heights(n);
  Eigen::Index k = 0;
  for (Eigen::Index j = 0; j < surface.rows(); ++j)
    for (Eigen::Index i = 0; i < surface.cols(); ++i) {
      if (is_missing(surface.z(j, i))) continue;
      const double x = static_cast<double>(i - col) * surface.dx / sigma;
      const double y = static_cast<double>(j - row) * surface.dy / sigma;
      const double root_weight = std::exp(-(x * x + y * y) / 4);
      design.row(k) << root_weight, root_weight * x, root_weight * y;
      heights[k++] = root_weight * static_cast<double>(surface.z(j, i));
    }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(design, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::VectorXd singular = svd.singularValues();
  const Eigen::Vector3d plane = design.colPivHouseholderQr().solve(heights);
  return {plane[1] / sigma, plane[2] / sigma, std::pow(singular[0] / singular[2], 2)};
}

HeightField random_surface(int rows, int cols, double dx, double dy, double hole_fraction,
                           std::uint64_t seed) {
  Grid<double> z(rows, cols);
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < cols; ++i) {
      const auto index = static_cast<std::uint64_t>(j * cols + i);
      const bool hole = random_uniform(seed, 1, index)[0] < hole_fraction;
      z(j, i) = hole ? std::nan("") : 0.2 * random_normal(seed, 0, index)[0] + 0.3 * i * dx - 0.1 * j * dy;
    }
  return make_height_field(z, dx, dy);
}

void expect_literal(const HeightField& surface, double sigma) {
  const SlopeField slopes = local_planes(surface, sigma);
  EXPECT_LE(slopes.truncation_error, kSlopeTolerance);
  Eigen::Index without = 0;
  for (Eigen::Index j = 0; j < surface.rows(); ++j)
    for (Eigen::Index i = 0; i < surface.cols(); ++i) {
      if (is_missing(surface.z(j, i))) {
        EXPECT_TRUE(std::isnan(slopes.zx(j, i)) && std::isnan(slopes.zy(j, i)));
        continue;
      }
      const LiteralFit literal = literal_fit(surface, sigma, j, i);
      if (!(1 / literal.condition >= kLeastCondition)) {
        ++without;
        EXPECT_TRUE(std::isnan(slopes.zx(j, i)) && std::isnan(slopes.zy(j, i))) << j << " " << i;
        continue;
      }
      ASSERT_LE(std::abs(slopes.zx(j, i) - literal.zx), kSlopeTolerance * literal.condition) << j << " " << i;
      ASSERT_LE(std::abs(slopes.zy(j, i) - literal.zy), kSlopeTolerance * literal.condition) << j << " " << i;
    }
  EXPECT_EQ(slopes.without_normal, without);
}

TEST(LocalPlanes, EqualTheLiteralFitOnACleanSurface) {
  expect_literal(random_surface(41, 45, 0.11, 0.11, 0, 1), 0.2);  // windows inside, at borders and in corners
}

TEST(LocalPlanes, EqualTheLiteralFitWithScatteredHoles) {
  expect_literal(random_surface(30, 37, 0.11, 0.11, 0.04, 2), 0.3);
}

TEST(LocalPlanes, EqualTheLiteralFitAroundOneHole) {
  HeightField surface = random_surface(40, 90, 0.11, 0.11, 0, 3);
  surface.z.block(18, 10, 2, 3) = kMissing;  // most of the surface has complete windows or known profiles
  expect_literal(surface, 0.2);
}

TEST(LocalPlanes, EqualTheLiteralFitOnAnisotropicPitch) {
  expect_literal(random_surface(35, 33, 0.1, 0.25, 0.1, 4), 0.4);
}

TEST(LocalPlanes, EqualTheLiteralFitWithAWindowLargerThanTheSurface) {
  expect_literal(random_surface(9, 13, 0.11, 0.11, 0.2, 5), 5);
}

TEST(LocalPlanes, EqualTheLiteralFitWithTheNarrowestWindow) {
  expect_literal(random_surface(20, 21, 0.1, 0.1, 0.3, 6), 0.05);
}

TEST(LocalPlanes, EqualTheLiteralFitWhenNearlyAllIsMissing) {
  expect_literal(random_surface(25, 40, 0.11, 0.11, 0.95, 7), 0.2);
}

TEST(LocalPlanes, ASingleRowHasNoNormals) {
  // Long enough for windows that no end cuts.
  for (const auto& [rows, cols] : {std::pair(1, 300), std::pair(300, 1), std::pair(1, 1)}) {
    const SlopeField slopes = local_planes(random_surface(rows, cols, 0.1, 0.1, 0, 8), 0.2);
    EXPECT_EQ(slopes.without_normal, rows * cols);
    EXPECT_TRUE(slopes.zx.isNaN().all());
    EXPECT_TRUE(slopes.zy.isNaN().all());
  }
  HeightField field = random_surface(20, 40, 0.1, 0.1, 0, 9);
  field.z.topRows(10) = kMissing;
  field.z.bottomRows(9) = kMissing;
  const SlopeField slopes = local_planes(field, 0.2);
  EXPECT_EQ(slopes.without_normal, 40);
  EXPECT_TRUE(slopes.zx.isNaN().all());
}

// One point far off a row of points determines a plane barely here and not at all there.
TEST(LocalPlanes, AgreeWithTheLiteralFitOnWhichPointsHaveANormal) {
  HeightField surface = random_surface(30, 60, 0.1, 0.1, 0, 11);
  const float far = surface.z(23, 30);
  const Eigen::ArrayXf row = surface.z.row(10);
  surface.z = kMissing;
  surface.z.row(10) = row;
  surface.z(23, 30) = far;
  const Eigen::Index without = local_planes(surface, 0.2).without_normal;
  EXPECT_GT(without, 10);
  EXPECT_LT(without, 59);
  expect_literal(surface, 0.2);
}

TEST(LocalPlanes, APlaneGivesItsOwnSlopes) {
  Grid<double> z(50, 60);
  for (int j = 0; j < 50; ++j)
    for (int i = 0; i < 60; ++i)
      z(j, i) = (i + j) % 7 == 0 ? std::nan("") : 3 * (i * 0.25) - 2 * (j * 0.5);
  const SlopeField slopes = local_planes(make_height_field(z, 0.25, 0.5), 0.5);
  constexpr double kFloatHeights = 1e-5;  // heights of ±50 µm are kept as float
  for (int j = 0; j < 50; ++j)
    for (int i = 0; i < 60; ++i) {
      if (std::isnan(z(j, i))) continue;
      EXPECT_NEAR(slopes.zx(j, i), 3, kFloatHeights);
      EXPECT_NEAR(slopes.zy(j, i), -2, kFloatHeights);
    }
}

TEST(LocalPlanes, AllMissingIsCountedNotFitted) {
  const HeightField surface = random_surface(10, 10, 0.1, 0.1, 2, 1);
  const SlopeField slopes = local_planes(surface, 0.5);
  EXPECT_EQ(slopes.without_normal, 0);
  EXPECT_TRUE(slopes.zx.isNaN().all());
}

TEST(LocalPlanes, RefusesASigmaBelowHalfThePitch) {
  const HeightField surface = random_surface(10, 10, 0.1, 0.25, 0, 1);
  EXPECT_THROW(local_planes(surface, 0.12), InputError);
  EXPECT_NO_THROW(local_planes(surface, 0.125));
  EXPECT_THROW(local_planes(surface, std::nan("")), InputError);
}

TEST(LocalPlanes, DoNotDependOnTheNumberOfThreads) {
  const HeightField surface = random_surface(100, 100, 0.11, 0.11, 0.02, 10);
  const int threads = thread_count();
  set_thread_count(1);
  const SlopeField one = local_planes(surface, 0.3);
  set_thread_count(5);
  const SlopeField five = local_planes(surface, 0.3);
  set_thread_count(threads);
  EXPECT_TRUE(((one.zx == five.zx) || one.zx.isNaN()).all());
  EXPECT_TRUE(((one.zy == five.zy) || one.zy.isNaN()).all());
}

}  // namespace
}  // namespace micro
