#include "height/statistics.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/parallel.h"
#include "core/random.h"
#include "height/autocorrelation.h"
#include "height/triangles.h"

namespace micro {
namespace {

/// Heights are stored as float.
constexpr double kFloatRounding = 1e-6;

Grid<double> waves(Eigen::Index rows, Eigen::Index cols) {
  Grid<double> z(rows, cols);
  for (Eigen::Index j = 0; j < rows; ++j)
    for (Eigen::Index i = 0; i < cols; ++i)
      z(j, i) = std::sin(0.9 * static_cast<double>(i)) + 0.5 * std::cos(0.4 * static_cast<double>(j)) +
                0.1 * random_normal(2, 0, static_cast<std::uint64_t>(j * cols + i))[0];
  return z;
}

Grid<double> with_holes(Grid<double> z) {
  for (Eigen::Index k = 0; k < z.size(); k += 7)
    z(k) = kMissing;
  return z;
}

TEST(HeightParameters, OfATwoLevelSurface) {
  // A quarter of the points at 3, the rest at −1: mean 0, every moment by hand.
  Grid<double> z = Grid<double>::Constant(4, 8, -1);
  z.row(2) = 3;
  z += 76000;
  const HeightField surface = make_height_field(z, 1, 1);
  const HeightParameters p = height_parameters(surface);
  EXPECT_NEAR(p.Sq, std::sqrt(3.), kFloatRounding);
  EXPECT_NEAR(p.Sa, 1.5, kFloatRounding);
  EXPECT_NEAR(p.Sz, 4, kFloatRounding);
  EXPECT_NEAR(p.Ssk, 6 / std::pow(3, 1.5), kFloatRounding);
  EXPECT_NEAR(p.Sku, 21. / 9, kFloatRounding);
  EXPECT_NEAR(Sq(surface), p.Sq, kFloatRounding);
  const HeightRange range = height_range(surface);
  EXPECT_NEAR(range.min, 75999, kFloatRounding);
  EXPECT_NEAR(range.max, 76003, kFloatRounding);
  EXPECT_NEAR(range.mean, 76000, kFloatRounding);
  EXPECT_NEAR(range.rms, p.Sq, kFloatRounding);
}

TEST(HeightParameters, AreAboutTheMeanOfTheValidPoints) {
  HeightField surface = make_height_field(with_holes(waves(30, 40)), 1, 1);
  const double expected = Sq(surface);
  surface.z += 5;  // a field whose mean is not 0 any more
  EXPECT_NEAR(Sq(surface), expected, kFloatRounding);
  EXPECT_NEAR(height_parameters(surface).Sq, expected, kFloatRounding);
}

TEST(HeightParameters, OfNothingAreNothing) {
  const HeightField missing = make_height_field(Grid<double>::Constant(3, 4, kMissing), 1, 1);
  EXPECT_TRUE(std::isnan(Sq(missing)) && std::isnan(Sdq(missing)) && std::isnan(Sdr(missing)));
  EXPECT_TRUE(std::isnan(height_parameters(missing).Sa) && std::isnan(height_range(missing).min));
  EXPECT_TRUE(std::isnan(texture_direction(missing).anisotropy));
  const HeightField flat = make_height_field(Grid<double>::Constant(3, 4, 2), 1, 1);
  EXPECT_EQ(Sq(flat), 0);
  EXPECT_EQ(Sdq(flat), 0);
  EXPECT_EQ(Sdr(flat), 0);
  EXPECT_TRUE(std::isnan(height_parameters(flat).Ssk) && std::isnan(texture_direction(flat).direction));
  for (const auto& [rows, cols] : {std::pair{1, 5}, {5, 1}, {1, 1}, {0, 0}}) {
    const HeightField line = make_height_field(Grid<double>::Zero(rows, cols), 1, 1);
    EXPECT_TRUE(std::isnan(Sdq(line)) && std::isnan(Sdr(line)));
  }
}

TEST(Slopes, OfAPlane) {
  Grid<double> z(9, 7);
  for (int j = 0; j < 9; ++j)
    for (int i = 0; i < 7; ++i)
      z(j, i) = 0.3 * (i * 0.5) - 0.4 * (j * 2.0);
  const HeightField plane = make_height_field(z, 0.5, 2);
  EXPECT_NEAR(Sdq(plane), 0.5, kFloatRounding);
  EXPECT_NEAR(Sdr(plane), std::sqrt(1.25) - 1, kFloatRounding);
  EXPECT_TRUE(std::isnan(texture_direction(plane).direction));
}

TEST(Slopes, AreIntegralsOverTheTriangles) {
  const HeightField surface = make_height_field(with_holes(waves(25, 33)), 0.5, 0.8);
  double gradient = 0, area = 0;
  const auto point = [&](const Eigen::Vector2i& p) {
    return Vec3(p.x() * surface.dx, p.y() * surface.dy, surface.z(p.y(), p.x()));
  };
  for (Eigen::Index j = 0; j + 1 < surface.rows(); ++j)
    for_each_triangle(surface, j, [&](const Triangle& t) {
      const Vec3 a = (point(t.b) - point(t.a)).cross(point(t.c) - point(t.a)) / 2;
      area += a.norm();
      gradient += a.head<2>().squaredNorm() / a.z();
    });
  EXPECT_NEAR(Sdr(surface), area / projected_area(surface) - 1, 1e-9);
  EXPECT_NEAR(Sdq(surface), std::sqrt(gradient / projected_area(surface)), 1e-9);
}

TEST(Slopes, DoNotDependOnTheNumberOfThreads) {
  const HeightField surface = make_height_field(waves(150, 70), 1, 1);
  set_thread_count(1);
  const double one = Sdr(surface) + Sq(surface);
  set_thread_count(3);
  const double three = Sdr(surface) + Sq(surface);
  set_thread_count(0);
  EXPECT_EQ(one, three);
}

TEST(TextureDirection, IsAlongTheGrooves) {
  for (const double degrees : {0., 20., 45., 90., -30., -85.}) {
    const double angle = degrees * std::numbers::pi / 180;
    Grid<double> z(120, 150);
    for (int j = 0; j < 120; ++j)
      for (int i = 0; i < 150; ++i)
        z(j, i) = std::sin(0.2 * (-std::sin(angle) * i + std::cos(angle) * j));
    const TextureDirection texture = texture_direction(make_height_field(z, 1, 1));
    EXPECT_NEAR(texture.direction, angle, 0.01);
    EXPECT_GE(texture.anisotropy, 0.99);
  }
}

TEST(TextureDirection, WhiteNoiseHasNone) {
  Grid<double> z(200, 200);
  for (Eigen::Index k = 0; k < z.size(); ++k)
    z(k) = random_normal(4, 0, static_cast<std::uint64_t>(k))[0];
  const TextureDirection texture = texture_direction(make_height_field(z, 1, 1));
  EXPECT_LE(texture.anisotropy, 0.03);
  EXPECT_TRUE(std::isnan(texture.direction));
}

TEST(Autocorrelation, IsTheLiteralSumOverPairs) {
  for (const auto& [rows, cols] : {std::pair{13, 20}, {1, 16}, {17, 1}, {2, 2}}) {
    for (const bool holes : {false, true}) {
      const Grid<double> heights = holes ? with_holes(waves(rows, cols)) : waves(rows, cols);
      const HeightField surface = make_height_field(heights, 1, 1);
      const Autocorrelation acf = autocorrelation(surface);
      const double mean = height_range(surface).mean - surface.mean, variance = std::pow(Sq(surface), 2);
      ASSERT_EQ(acf.rho.rows(), rows / 2 + 1);
      ASSERT_EQ(acf.rho.cols(), 2 * (cols / 2) + 1);
      for (Eigen::Index dj = 0; dj < acf.rho.rows(); ++dj)
        for (Eigen::Index di = -acf.zero; di <= acf.zero; ++di) {
          double sum = 0, pairs = 0;
          for (Eigen::Index j = 0; j + dj < rows; ++j)
            for (Eigen::Index i = std::max<Eigen::Index>(0, -di); i < std::min<Eigen::Index>(cols, cols - di);
                 ++i) {
              const double product = (surface.z(j, i) - mean) * (surface.z(j + dj, i + di) - mean);
              if (!std::isnan(product)) sum += product, pairs += 1;
            }
          if (pairs == 0)
            EXPECT_TRUE(std::isnan(acf.rho(dj, acf.zero + di)));
          else
            EXPECT_NEAR(acf.rho(dj, acf.zero + di), sum / pairs / variance, 1e-12);
        }
    }
  }
}

/// exp(−x'²/a² − y'²/b²), turned.
Autocorrelation gaussian(double a, double b, double angle, double dx, double dy) {
  Autocorrelation acf{Grid<double>(151, 301), 150, dx, dy};
  for (Eigen::Index j = 0; j < 151; ++j)
    for (Eigen::Index i = 0; i < 301; ++i) {
      const double x = static_cast<double>(i - 150) * dx, y = static_cast<double>(j) * dy;
      const double u = (x * std::cos(angle) + y * std::sin(angle)) / a;
      const double v = (y * std::cos(angle) - x * std::sin(angle)) / b;
      acf.rho(j, i) = std::exp(-u * u - v * v);
    }
  return acf;
}

TEST(CorrelationLengths, OfAGaussian) {
  const double decay = std::sqrt(std::log(5.));  // where exp(−r²) = 0.2
  constexpr double kInterpolation = 0.01;        // linear between points a fifteenth of a length apart
  for (const double angle : {0., 0.4, -1.2, std::numbers::pi / 2})
    for (const double dy : {0.2, 0.25}) {
      const CorrelationLengths lengths = correlation_lengths(gaussian(8, 3, angle, 0.2, dy), angle);
      EXPECT_NEAR(lengths.Sal, 3 * decay, kInterpolation);
      EXPECT_NEAR(lengths.Str, 3. / 8, kInterpolation);
      EXPECT_NEAR(lengths.along, 8, kInterpolation);
      EXPECT_NEAR(lengths.across, 3, kInterpolation);
    }
}

TEST(CorrelationLengths, TheOtherHalfPlaneIsTheMirrorImage) {
  // The region leaves lag 0 downwards, comes back to row 0 at lag 2, and goes on above it, where it is the
  // image of what lies below lag −2.
  Autocorrelation acf{Grid<double>::Zero(5, 9), 4, 1, 1};
  acf.rho(0, 4) = 1;
  for (const auto& [j, i] : {std::pair{1, 0}, {1, 1}, {1, 2}, {0, 2}, {0, -2}, {1, -2}, {2, -2}})
    acf.rho(j, 4 + i) = 0.9;
  const CorrelationLengths lengths = correlation_lengths(acf, 0);
  EXPECT_NEAR(lengths.Sal, 0.8, 1e-12);                              // from 1 to 0 along row 0
  EXPECT_NEAR(lengths.Str, 0.8 / std::hypot(2, 2 + 7. / 9), 1e-12);  // from 0.9 to 0 beyond (−2, 2)
}

TEST(CorrelationLengths, WhatDoesNotDecayIsNone) {
  const CorrelationLengths grooves = correlation_lengths(gaussian(1e9, 3, 0, 0.2, 0.2), 0);
  EXPECT_NEAR(grooves.Sal, 3 * std::sqrt(std::log(5.)), 0.01);
  EXPECT_TRUE(std::isnan(grooves.Str) && std::isnan(grooves.along));
  EXPECT_NEAR(grooves.across, 3, 0.01);
  const HeightField flat = make_height_field(Grid<double>::Zero(5, 6), 1, 1);
  EXPECT_TRUE(std::isnan(correlation_lengths(autocorrelation(flat), 0).Sal));
}

TEST(CorrelationLengths, AProfileHasNoAspectRatio) {
  Grid<double> row(1, 9);
  row << 0, 1, 0, -1, 0, 1, 0, -1, 0;
  for (const Grid<double>& z : {row, Grid<double>(row.transpose())}) {
    const CorrelationLengths lengths = correlation_lengths(autocorrelation(make_height_field(z, 1, 1)), 0);
    EXPECT_GT(lengths.Sal, 0);
    EXPECT_TRUE(std::isnan(lengths.Str));
  }
}

}  // namespace
}  // namespace micro
