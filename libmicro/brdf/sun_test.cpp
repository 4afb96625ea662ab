#include "brdf/sun.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "brdf/albedo.h"
#include "core/error.h"
#include "testing/brdf_sampling.h"

namespace micro {
namespace {

constexpr double kLambda = 0.55, kRounding = 1e-12;
constexpr double kLeastP = 1e-4;  // of ten tests with fixed seeds
using testing::direction;
const double kSmoothness[] = {0.1, 0.5, 1, 3, 10, 100, 1e6};

/// [Sun02 Eqs. 3.2.7, 3.2.8, 3.4.23, 3.5.3] in angles, F = 1: printed, and corrected by its cosines.
double literal_f(double s, const Vec3& wi, const Vec3& wo, SunForm form) {
  const double tl = std::acos(wi.z()), tv = std::acos(wo.z());
  const double azimuth = std::atan2(wi.y(), wi.x()) - std::atan2(wo.y(), wo.x());
  const double cos_delta = std::sin(tl) * std::sin(tv) * std::cos(azimuth) + std::cos(tl) * std::cos(tv);
  const double cos_half = std::cos(std::acos(cos_delta) / 2);
  const double c = (std::cos(tl) + std::cos(tv)) / std::sqrt(2 + 2 * cos_delta), tan2 = 1 / (c * c) - 1;
  const auto gamma = [s](double t) {
    return std::exp(-std::tan(t) / (std::sqrt(2 * std::numbers::pi) * s) *
                    std::exp(-s * s / (4 * std::tan(t) * std::tan(t))));
  };
  const double rest = s * s * std::exp(-s * s * tan2 / 4) * gamma(tl) * gamma(tv) / (16 * std::numbers::pi);
  return form == SunForm::AsPrinted ? rest / (c * c * c * cos_half)
                                    : rest / (c * c * c * c * std::cos(tl) * std::cos(tv));
}

TEST(Sun, BothFormsAreTheLiteralOnes) {
  for (const SunForm form : {SunForm::Corrected, SunForm::AsPrinted})
    for (const double s : {0.5, 1., 3., 10.})
      for (const auto& [wi, wo] :
           {std::pair{direction(10), direction(40, 1)}, std::pair{direction(45, 2), direction(60, 5)},
            std::pair{direction(80), direction(70, 3)}, std::pair{direction(30), direction(30, 3)}}) {
        const double literal = literal_f(s, wi, wo, form);
        EXPECT_LE(std::abs(SunReflection(s, Fresnel(), form).f(wi, wo, kLambda) - literal), 1e-9 * literal);
      }
}

TEST(Sun, PrintedLacksACosineInTheMirrorsDirection) {
  for (const double degrees : {0., 30., 60., 85.}) {
    const Vec3 wi = direction(degrees), wo = direction(degrees, std::numbers::pi);
    const double ratio = SunReflection(5, Fresnel(), SunForm::AsPrinted).f(wi, wo, kLambda) /
                         SunReflection(5).f(wi, wo, kLambda);
    EXPECT_NEAR(ratio, wi.z(), kRounding);
  }
}

TEST(Sun, IsReciprocal) {
  for (const SunForm form : {SunForm::Corrected, SunForm::AsPrinted})
    for (const double s : kSmoothness) {
      const Reciprocity found = reciprocity(SunReflection(s, Fresnel(std::complex(0.2, 3.)), form), kLambda);
      EXPECT_LE(found.difference, kRounding) << s << " at " << found.wi.transpose();
    }
}

TEST(Sun, FreeTravelLiesBelowSmith) {
  for (const double s : kSmoothness) {
    const SunNormals normals(s);
    const Beckmann& smith = normals;
    for (double degrees = 0; degrees < 90; degrees += 0.25)
      EXPECT_LE(normals.G1(direction(degrees)), smith.G1(direction(degrees)) * (1 + kRounding))
          << s << ' ' << degrees;
    EXPECT_LE(normals.G1(direction(89.999)), smith.G1(direction(89.999)) * (1 + kRounding));
    EXPECT_EQ(normals.G1({0, 0, 1}), 1);
    EXPECT_EQ(normals.G1({0, 0, -1}), 0);
  }
}

TEST(Sun, CorrectedReflectsNoMoreThanComes) {
  constexpr double kTolerance = 1e-2;
  for (const double s : kSmoothness)
    EXPECT_LE(white_furnace(SunReflection(s), kLambda, kTolerance,
                            {direction(0), direction(45), direction(75), direction(85), direction(89.9),
                             direction(89.999)})
                  .most(),
              1)
        << s;
}

/// docs/sun.md: with the light at 0, 45 and 80 degrees.
TEST(Sun, FurnaceOfPrintedFormIsTheDocumentedOne) {
  constexpr double kTolerance = 1e-3, kPrintedDigits = 3e-3;
  const struct {
    double s, degrees, albedo;
  } cases[] = {{1, 0, 0.055}, {1, 45, 0.056}, {20, 0, 0.980}, {20, 45, 0.693}, {20, 80, 0.174}};
  for (const auto& [s, degrees, expected] : cases) {
    const Estimate<double> found =
        albedo(SunReflection(s, Fresnel(), SunForm::AsPrinted), direction(degrees), kLambda, kTolerance);
    EXPECT_NEAR(found.value, expected, kPrintedDigits) << s << ' ' << degrees;
  }
}

TEST(Sun, SamplesFollowTheirDensity) {
  for (const SunForm form : {SunForm::Corrected, SunForm::AsPrinted})
    for (const double s : {0.5, 2., 20.})
      for (const double degrees : {5., 65.}) {
        const auto found = testing::test_sampling(SunReflection(s, Fresnel(), form), direction(degrees, 1),
                                                  kLambda, 20000, 3);
        EXPECT_GE(found.p, kLeastP) << s << ' ' << degrees;
        EXPECT_LE(found.largest_mismatch, 1e-9);
        EXPECT_LE(found.integral, 1 + 1e-3);
      }
  // A smooth surface absorbs nothing.
  EXPECT_NEAR(testing::test_sampling(SunReflection(20), direction(30), kLambda, 1, 3).integral, 1, 1e-3);
}

TEST(Sun, ExtremesStayFinite) {
  for (const SunForm form : {SunForm::Corrected, SunForm::AsPrinted})
    for (const double s : {0.1, 1., 20., 1e6}) {
      const SunReflection sun(s, Fresnel(std::complex(0.2, 3.)), form);
      for (const double in : {0., 45., 89., 89.999})
        for (const double out : {0., 45., 89., 89.999})
          for (const double azimuth : {0., 1., std::numbers::pi}) {
            const double f = sun.f(direction(in), direction(out, azimuth), kLambda);
            EXPECT_TRUE(f >= 0 && std::isfinite(f)) << s << ' ' << in << ' ' << out << ' ' << f;
          }
    }
  EXPECT_EQ(SunReflection(1).f({0, 0, 1}, {1, 0, 0}, kLambda), 0);
  EXPECT_EQ(SunReflection(1).f({0, 0, 1}, {0, 0, -1}, kLambda), 0);
  for (const double s : {0., -1., std::nan(""), std::numeric_limits<double>::infinity()})
    EXPECT_THROW(SunReflection{s}, InputError);
}

}  // namespace
}  // namespace micro
