#include "height/height_field.h"

#include <gtest/gtest.h>

#include "core/error.h"

namespace micro {
namespace {

TEST(HeightField, KeepsEightNanometresOnSeventySixMillimetres) {
  Grid<double> z(100, 100);
  for (int j = 0; j < 100; ++j)
    for (int i = 0; i < 100; ++i)
      z(j, i) = 76000 + ((i + j) % 2 ? 0.008 : -0.008);
  const HeightField surface = make_height_field(z, 1, 1);
  EXPECT_NEAR(surface.mean, 76000, 1e-9);
  EXPECT_NEAR(std::sqrt(surface.z.square().cast<double>().mean()), 0.008, 1e-9);
}

TEST(HeightField, WhatIsNotFiniteIsMissing) {
  Grid<double> z = Grid<double>::Constant(2, 3, 5);
  z(0, 1) = std::numeric_limits<double>::infinity();
  z(1, 2) = std::numeric_limits<double>::quiet_NaN();
  const HeightField surface = make_height_field(z, 1, 1);
  EXPECT_EQ(missing_count(surface), 2);
  EXPECT_TRUE(is_missing(surface.z(0, 1)));
  EXPECT_DOUBLE_EQ(surface.mean, 5);
}

TEST(HeightField, RefusesAPitchThatIsNone) {
  const Grid<double> z = Grid<double>::Zero(2, 2);
  EXPECT_THROW(make_height_field(z, 0, 1), InputError);
  EXPECT_THROW(make_height_field(z, 1, -1), InputError);
  EXPECT_THROW(make_height_field(z, 1, std::numeric_limits<double>::quiet_NaN()), InputError);
}

}  // namespace
}  // namespace micro
