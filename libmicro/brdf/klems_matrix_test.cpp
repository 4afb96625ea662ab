#include "brdf/klems_matrix.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "brdf/albedo.h"
#include "brdf/microfacet.h"
#include "distribution/ellipsoid.h"

namespace micro {
namespace {

constexpr double kPi = std::numbers::pi;

AnyBrdf mirror_of(const EllipsoidParameters& parameters) {
  return AnyBrdf(Microfacet(Ellipsoid(slope_frame(parameters)), Fresnel()));
}

double column_sum(const KlemsMatrix& matrix, std::size_t column) {
  double sum = 0;
  for (std::size_t row = 0; row < kKlemsPatches; ++row)
    sum += matrix.f[row * kKlemsPatches + column] * klems_projected_solid_angle(row);
  return sum;
}

TEST(KlemsMatrix, PatchesCoverTheHemisphere) {
  double sum = 0;
  for (std::size_t k = 0; k < kKlemsPatches; ++k)
    sum += klems_projected_solid_angle(k);
  EXPECT_NEAR(sum, kPi, 1e-12);
}

TEST(KlemsMatrix, NumbersPatchesByRingsAndAzimuths) {
  const auto at = [](double theta, double phi) {
    const double t = theta * kPi / 180, p = phi * kPi / 180;
    return klems_patch({std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t)});
  };
  EXPECT_EQ(at(0, 0), 0u);
  EXPECT_EQ(at(4.9, 200), 0u);
  EXPECT_EQ(at(10, 0), 1u);
  EXPECT_EQ(at(10, 22), 1u);  // 45° a patch, the first about 0
  EXPECT_EQ(at(10, -22), 1u);
  EXPECT_EQ(at(10, 45), 2u);
  EXPECT_EQ(at(20, 0), 9u);
  EXPECT_EQ(at(82.5, 0), 133u);
  EXPECT_EQ(at(89.9, 330), 144u);
}

// What light loses to shadows alone: the albedo of a mirror's facets, found another way.
TEST(KlemsMatrix, ColumnsHoldTheDirectionalAlbedo) {
  const AnyBrdf model = mirror_of({0.4, 0.2});
  const KlemsMatrix matrix = klems_matrix(model, {0.55}, {1}, 4096);
  for (const std::size_t column : {std::size_t{0}, std::size_t{30}, std::size_t{140}}) {
    double mean = 0;
    constexpr int kSteps = 12;
    // Over the patch by cosθ dω, as a literal mean.
    const double low = column == 0    ? 0
                       : column == 30 ? 25
                                      : 75,
                 high = column == 0    ? 5
                        : column == 30 ? 35
                                       : 90;
    const double first = column == 30 ? 5 : 7, turns = column == 0 ? 1 : column == 30 ? 20 : 12;
    for (int a = 0; a < kSteps; ++a)
      for (int b = 0; b < kSteps; ++b) {
        const double s0 = std::pow(std::sin(low * kPi / 180), 2),
                     s1 = std::pow(std::sin(high * kPi / 180), 2);
        const double sine = std::sqrt(s0 + (s1 - s0) * (a + 0.5) / kSteps);
        const double phi = 2 * kPi * ((column == 0 ? 0 : first) + (b + 0.5) / kSteps - 0.5) / turns;
        mean += albedo(model, {-sine * std::cos(phi), -sine * std::sin(phi), std::sqrt(1 - sine * sine)},
                       0.55, 3e-3)
                    .value;
      }
    mean /= kSteps * kSteps;
    EXPECT_NEAR(column_sum(matrix, column), mean, 5 * matrix.standard_error + 1e-3) << column;
  }
}

TEST(KlemsMatrix, IsReciprocalAndAsRightAsManyMoreRays) {
  // Light that goes into patch b when it comes from a goes into the one opposite to a from the one opposite
  // to b.
  for (const double theta : {0., 12., 33., 61., 88.})
    for (int k = 0; k < 40; ++k) {
      const double t = theta * kPi / 180, phi = 0.157 * k;
      const Vec3 w(std::sin(t) * std::cos(phi), std::sin(t) * std::sin(phi), std::cos(t));
      EXPECT_EQ(klems_opposite(klems_patch(w)), klems_patch({-w.x(), -w.y(), w.z()})) << theta << " " << k;
    }
  const AnyBrdf model = mirror_of({0.4, 0.2, 0.1, -0.2, 0.3});
  const KlemsMatrix few = klems_matrix(model, {0.55}, {1}, 1024),
                    many = klems_matrix(model, {0.55}, {1}, 16384);
  double difference = 0, square = 0;
  for (std::size_t row = 0; row < kKlemsPatches; ++row)
    for (std::size_t column = 0; column < kKlemsPatches; ++column) {
      const double value = few.f[row * kKlemsPatches + column];
      EXPECT_EQ(value, few.f[klems_opposite(column) * kKlemsPatches + klems_opposite(row)]);
      difference += std::pow(value - many.f[row * kKlemsPatches + column], 2);
      square += value * value;
    }
  constexpr double kNoise = 0.15;  // measured 0.125; of independent rays, not pooled: 0.21
  EXPECT_LE(std::sqrt(difference / square), kNoise);
}

TEST(KlemsMatrix, OfAMirrorIsDiagonal) {
  const KlemsMatrix matrix = klems_matrix(mirror_of({1e-4, 1e-4}), {0.55}, {1}, 256);
  for (std::size_t k = 0; k < kKlemsPatches; ++k)
    EXPECT_NEAR(matrix.f[k * kKlemsPatches + k] * klems_projected_solid_angle(k), 1, 0.05) << k;
}

}  // namespace
}  // namespace micro
