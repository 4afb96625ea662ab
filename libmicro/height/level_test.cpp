#include "height/level.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "core/parallel.h"
#include "core/random.h"

namespace micro {
namespace {

/// Heights are stored as float; those below are a few µm.
constexpr double kFloatRounding = 1e-6;

double noise(Eigen::Index j, Eigen::Index i) {
  return random_normal(5, 0, static_cast<std::uint64_t>(j * 10007 + i))[0];
}

Grid<double> rough(Eigen::Index rows, Eigen::Index cols) {
  Grid<double> z(rows, cols);
  for (Eigen::Index j = 0; j < rows; ++j)
    for (Eigen::Index i = 0; i < cols; ++i)
      z(j, i) = noise(j, i) + 0.02 * static_cast<double>(i) - 0.03 * static_cast<double>(j) +
                1e-4 * static_cast<double>(i * j + 2 * i * i - j * j);
  return z;
}

/// The residual of the literal least squares: one row of the design matrix per valid point, solved by a
/// singular value decomposition, which gives the minimum norm.
Grid<double> literal(const HeightField& surface, Level level) {
  const int terms = level == Level::Mean ? 1 : level == Level::Plane ? 3 : 6;
  const double cx = static_cast<double>(surface.cols()) / 2, cy = static_cast<double>(surface.rows()) / 2;
  const auto basis = [&](Eigen::Index j, Eigen::Index i) {
    const double u = (static_cast<double>(i) - cx) / (cx + 1), v = (static_cast<double>(j) - cy) / (cy + 1);
    return Eigen::Matrix<double, 1, 6>(1, u, v, u * u, u * v, v * v);
  };
  const Eigen::Index n = surface.z.size() - missing_count(surface);
  Eigen::MatrixXd a(n, terms);
  Eigen::VectorXd b(n);
  Eigen::Index k = 0;
  for (Eigen::Index j = 0; j < surface.rows(); ++j)
    for (Eigen::Index i = 0; i < surface.cols(); ++i)
      if (!is_missing(surface.z(j, i))) {
        a.row(k) = basis(j, i).head(terms);
        b(k++) = surface.z(j, i);
      }
  const Eigen::VectorXd c =
      n > 0 ? Eigen::VectorXd(a.bdcSvd(Eigen::ComputeThinU | Eigen::ComputeThinV).solve(b))
            : Eigen::VectorXd::Zero(terms);
  Grid<double> residual = surface.z.cast<double>();
  for (Eigen::Index j = 0; j < surface.rows(); ++j)
    for (Eigen::Index i = 0; i < surface.cols(); ++i)
      residual(j, i) -= basis(j, i).head(terms).dot(c);
  return residual;
}

void expect_literal(const HeightField& surface) {
  for (const Level how : {Level::Mean, Level::Plane, Level::Quadratic}) {
    const HeightField levelled = level(surface, how);
    const Grid<double> expected = literal(surface, how);
    EXPECT_EQ(missing_count(levelled), missing_count(surface));
    for (Eigen::Index j = 0; j < surface.rows(); ++j)
      for (Eigen::Index i = 0; i < surface.cols(); ++i)
        if (!is_missing(surface.z(j, i))) {
          ASSERT_LE(std::abs(levelled.z(j, i) - expected(j, i)), kFloatRounding)
              << name_of(how) << " " << surface.rows() << "x" << surface.cols();
        }
  }
}

TEST(Level, IsTheLiteralLeastSquaresOnCompleteGrids) {
  for (const auto& [rows, cols] : {std::pair{20, 31}, {1, 30}, {30, 1}, {2, 9}, {1, 1}, {2, 2}, {3, 3}})
    expect_literal(make_height_field(rough(rows, cols), 0.1, 0.3));
}

TEST(Level, IsTheLiteralLeastSquaresWithHoles) {
  Grid<double> z = rough(24, 33);
  for (Eigen::Index k = 0; k < z.size(); k += 3)
    z(k) = kMissing;
  expect_literal(make_height_field(z, 1, 1));
}

TEST(Level, FewPointsInACornerAreFittedAndStayFinite) {
  for (int points = 0; points <= 7; ++points) {
    Grid<double> z = Grid<double>::Constant(400, 500, kMissing);
    const int at[7][2] = {{390, 490}, {391, 493}, {395, 491}, {396, 497}, {399, 499}, {398, 490}, {392, 495}};
    for (int k = 0; k < points; ++k)
      z(at[k][0], at[k][1]) = noise(k, 0);
    const HeightField surface = make_height_field(z, 1, 1);
    for (const Level how : {Level::Mean, Level::Plane, Level::Quadratic}) {
      const HeightField levelled = level(surface, how);
      double residual = 0;
      for (int k = 0; k < points; ++k)
        residual += std::abs(levelled.z(at[k][0], at[k][1]));
      EXPECT_EQ(missing_count(levelled), z.size() - points);
      EXPECT_LE(residual, 10 * points);
      const int terms = how == Level::Mean ? 1 : how == Level::Plane ? 3 : 6;
      if (points <= terms) {
        EXPECT_LE(residual, 1e-5) << points << " points, " << name_of(how);
      }
    }
  }
}

TEST(Level, PointsOnOneLineAreFitted) {
  Grid<double> z = Grid<double>::Constant(50, 50, kMissing);
  for (int k = 0; k < 50; ++k)
    z(k, k) = 3 + 0.5 * k;
  const HeightField levelled = level(make_height_field(z, 1, 1), Level::Plane);
  for (int k = 0; k < 50; ++k)
    EXPECT_LE(std::abs(levelled.z(k, k)), kFloatRounding);
}

TEST(Level, KeepsEightNanometresUnderSeventySixMillimetresAndATilt) {
  constexpr int kSize = 200;
  Grid<double> z(kSize, kSize), roughness(kSize, kSize);
  for (int j = 0; j < kSize; ++j)
    for (int i = 0; i < kSize; ++i) {
      roughness(j, i) = 0.008 * noise(j, i);
      z(j, i) = 76000 + 0.1 * i - 0.2 * j + roughness(j, i);
    }
  const HeightField a = level(make_height_field(z, 1, 1), Level::Plane);
  const HeightField b = level(make_height_field(roughness, 1, 1), Level::Plane);
  EXPECT_EQ(a.mean, 0);
  // A tilt of 60 µm in float costs 2 pm; the roughness is 8 nm.
  EXPECT_LE((a.z - b.z).abs().maxCoeff(), 4e-6);
}

TEST(Level, NoneChangesNothing) {
  const HeightField surface = make_height_field(rough(5, 7), 1, 1);
  const HeightField same = level(surface, Level::None);
  EXPECT_TRUE((same.z == surface.z).all());
  EXPECT_EQ(same.mean, surface.mean);
}

TEST(Level, DoesNotDependOnTheNumberOfThreads) {
  Grid<double> z = rough(150, 90);
  z(7, 7) = kMissing;
  const HeightField surface = make_height_field(z, 1, 1);
  set_thread_count(1);
  const HeightField one = level(surface, Level::Quadratic);
  set_thread_count(3);
  const HeightField three = level(surface, Level::Quadratic);
  set_thread_count(0);
  EXPECT_EQ((one.z != three.z).count(), 1);  // the missing one differs from itself
}

TEST(Level, HasNames) {
  for (const Level how : kLevels)
    EXPECT_EQ(level_from_name(name_of(how)), how);
  EXPECT_EQ(level_from_name("cubic"), std::nullopt);
}

}  // namespace
}  // namespace micro
