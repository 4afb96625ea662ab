#include "height/repair.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "core/random.h"

namespace micro {
namespace {

constexpr double kFloatRounding = 2e-6;

double noise(Eigen::Index k) {
  return random_normal(3, 0, static_cast<std::uint64_t>(k))[0];
}

/// x² − y² and x + 2y: the five-point Laplacian of both is exactly 0, so they are what a hole must hold.
Grid<double> harmonic(Eigen::Index rows, Eigen::Index cols, double dx, double dy) {
  Grid<double> z(rows, cols);
  for (Eigen::Index j = 0; j < rows; ++j)
    for (Eigen::Index i = 0; i < cols; ++i) {
      const double x = dx * static_cast<double>(i), y = dy * static_cast<double>(j);
      z(j, i) = 0.01 * (x * x - y * y) + 0.1 * (x + 2 * y);
    }
  return z;
}

TEST(FillHoles, RestoresAHarmonicSurface) {
  for (const double dy : {1., 0.3, 2.}) {
    const Grid<double> truth = harmonic(30, 40, 1, dy);
    Grid<double> z = truth;
    z.block(5, 7, 12, 20) = kMissing;
    z(25, 30) = kMissing;
    const Repair repair = fill_holes(make_height_field(z, 1, dy));
    EXPECT_EQ(repair.changed, 12 * 20 + 1);
    EXPECT_LE((repair.surface.z.cast<double>() + repair.surface.mean - truth).abs().maxCoeff(),
              kFloatRounding * 10);
  }
}

TEST(FillHoles, IsReflectedAtTheBorder) {
  Grid<double> z = Grid<double>::Constant(9, 5, kMissing);
  z.row(0) = 1;
  z.row(8) = 3;
  const Repair repair = fill_holes(make_height_field(z, 1, 1));
  for (int j = 0; j < 9; ++j)
    for (int i = 0; i < 5; ++i)
      EXPECT_NEAR(repair.surface.z(j, i) + repair.surface.mean, 1 + j * 0.25, kFloatRounding);
}

TEST(FillHoles, NinetyFivePercentMissingStayInsideTheirNeighbours) {
  Grid<double> z(120, 160);
  for (Eigen::Index k = 0; k < z.size(); ++k)
    z(k) = random_uniform(9, 0, static_cast<std::uint64_t>(k))[0] < 0.05 ? noise(k) : kMissing;
  const HeightField surface = make_height_field(z, 1, 1);
  const Repair repair = fill_holes(surface);
  EXPECT_EQ(missing_count(repair.surface), 0);
  EXPECT_EQ(repair.changed, missing_count(surface));
  double low = 1e9, high = -1e9;
  for (const float value : surface.z.reshaped())
    if (!is_missing(value)) low = std::min<double>(low, value), high = std::max<double>(high, value);
  EXPECT_GE(repair.surface.z.minCoeff(), low - kFloatRounding);  // the maximum principle
  EXPECT_LE(repair.surface.z.maxCoeff(), high + kFloatRounding);
}

TEST(FillHoles, OnePointFillsAllAndNoneIsRefused) {
  Grid<double> z = Grid<double>::Constant(6, 7, kMissing);
  EXPECT_THROW(fill_holes(make_height_field(z, 1, 1)), InputError);
  z(5, 0) = 4;
  const Repair repair = fill_holes(make_height_field(z, 1, 1e-3));
  EXPECT_LE((repair.surface.z + 0.f).abs().maxCoeff(), kFloatRounding);
  EXPECT_EQ(repair.changed, 41);
}

TEST(FillHoles, ACompleteSurfaceIsLeftAlone) {
  const HeightField surface = make_height_field(harmonic(4, 5, 1, 1), 1, 1);
  const Repair repair = fill_holes(surface);
  EXPECT_EQ(repair.changed, 0);
  EXPECT_TRUE((repair.surface.z == surface.z).all());
}

TEST(RejectOutliers, FindsSpikesAndNothingElse) {
  Grid<double> z(100, 120);
  for (Eigen::Index k = 0; k < z.size(); ++k)
    z(k) = 0.01 * noise(k) + 0.05 * static_cast<double>(k % 120);  // a tilt of 5 σ per point
  const Eigen::Index spikes[] = {0, 119, 5 * 120 + 60, 99 * 120 + 3, 99 * 120 + 119};
  for (const Eigen::Index k : spikes)
    z(k) += 3;
  const HeightField surface = make_height_field(z, 1, 1);
  const Repair repair = reject_outliers(surface);
  EXPECT_EQ(repair.changed, 5);
  for (const Eigen::Index k : spikes)
    EXPECT_TRUE(is_missing(repair.surface.z(k))) << k;
  EXPECT_NEAR(repair.largest_change, 3, 0.2);
}

TEST(RejectOutliers, KeepsNormalNoiseSawtoothAndFlat) {
  Grid<double> normal(200, 200), sawtooth(60, 60);
  for (Eigen::Index k = 0; k < normal.size(); ++k)
    normal(k) = noise(k);
  for (Eigen::Index k = 0; k < sawtooth.size(); ++k)
    sawtooth(k) = static_cast<double>(k % 60 % 6);
  for (const Grid<double>& z : {normal, sawtooth, Grid<double>(Grid<double>::Zero(30, 30))})
    EXPECT_EQ(reject_outliers(make_height_field(z, 1, 1)).changed, 0);
}

TEST(RejectOutliers, ASpikeOnAMirrorGoesAndLonelyPointsStay) {
  Grid<double> z = Grid<double>::Zero(30, 30);
  z(12, 13) = 1e-3;
  EXPECT_EQ(reject_outliers(make_height_field(z, 1, 1)).changed, 1);
  z.setConstant(kMissing);
  EXPECT_EQ(reject_outliers(make_height_field(z, 1, 1)).changed, 0);
  z(3, 3) = 1;
  z(20, 20) = 100;
  EXPECT_EQ(reject_outliers(make_height_field(z, 1, 1)).changed, 0);
}

}  // namespace
}  // namespace micro
