#include "brdf/coat.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "brdf/albedo.h"
#include "core/error.h"
#include "distribution/ellipsoid.h"
#include "testing/brdf_sampling.h"

namespace micro {
namespace {

constexpr double kLambda = 0.55, kRounding = 1e-12;
constexpr double kLeastP = 1e-4;
using testing::direction;

static_assert(Brdf<Coated<SunReflection>>);
static_assert(Brdf<Coated<Microfacet<Ellipsoid>>>);
static_assert(Brdf<Coated<Coated<SunReflection>>>);

/// [SunGlossy Eqs. 2, 6–10] in angles as printed, the substrate a perfect mirror of slopes.
double literal_printed(double s_top, double s, double n, const Vec3& wi, const Vec3& wo) {
  const auto term = [](double smooth, double tl, double tv, double azimuth, auto&& fresnel) {
    const double cos_delta = std::sin(tl) * std::sin(tv) * std::cos(azimuth) + std::cos(tl) * std::cos(tv);
    const double cos_half = std::cos(std::acos(cos_delta) / 2);
    const double c = (std::cos(tl) + std::cos(tv)) / std::sqrt(2 + 2 * cos_delta);
    return fresnel(cos_half) * smooth * smooth * std::exp(-smooth * smooth * (1 / (c * c) - 1) / 4) /
           (16 * std::numbers::pi * c * c * c * cos_half);
  };
  // [Sun02 Eq. 5.4] with R⊥ as it should be.
  const auto dielectric = [n](double cos_i) {
    const double cos_t = std::sqrt(1 - (1 - cos_i * cos_i) / (n * n));
    const double parallel = (n * cos_i - cos_t) / (n * cos_i + cos_t);
    const double across = (cos_i - n * cos_t) / (cos_i + n * cos_t);
    return (parallel * parallel + across * across) / 2;
  };
  const auto gamma = [s](double t) {
    return std::exp(-std::tan(t) / (std::sqrt(2 * std::numbers::pi) * s) *
                    std::exp(-s * s / (4 * std::tan(t) * std::tan(t))));
  };
  const double tl = std::acos(wi.z()), tv = std::acos(wo.z());
  const double azimuth = std::atan2(wi.y(), wi.x()) - std::atan2(wo.y(), wo.x());
  const double inside_l = std::asin(std::sin(tl) / n), inside_v = std::asin(std::sin(tv) / n);
  return term(s_top, tl, tv, azimuth, dielectric) +
         (1 - dielectric(wi.z())) * (1 - dielectric(wo.z())) * gamma(inside_l) * gamma(inside_v) *
             term(s, inside_l, inside_v, azimuth, [](double) { return 1; });
}

Coated<SunReflection> printed(double s, double n, double s_top) {
  return Coated(SunReflection(s, Fresnel(), SunForm::AsPrinted), {n, s_top}, SunForm::AsPrinted);
}

TEST(Coat, AsPrintedIsTheLiteralForm) {
  for (const double s : {0.5, 2., 20.})
    for (const auto& [wi, wo] :
         {std::pair{direction(10), direction(14, 3)}, std::pair{direction(45, 2), direction(60, 5)},
          std::pair{direction(75), direction(75, 3.1)}}) {
      const double literal = literal_printed(30, s, 1.5, wi, wo);
      EXPECT_LE(std::abs(printed(s, 1.5, 30).f(wi, wo, kLambda) - literal), 1e-8 * literal);
    }
}

TEST(Coat, OfIndexOneIsTheBareSubstrate) {
  const SunReflection bare(2, Fresnel(std::complex(0.2, 3.)));
  const Coated coated(bare, {1, 50});
  for (const double in : {0., 30., 80., 89.999})
    for (const double out : {5., 60., 89.999}) {
      const Vec3 wi = direction(in), wo = direction(out, 2);
      EXPECT_LE(std::abs(coated.f(wi, wo, kLambda) - bare.f(wi, wo, kLambda)),
                kRounding * bare.f(wi, wo, kLambda));
      EXPECT_LE(std::abs(coated.pdf(wi, wo, kLambda) - bare.pdf(wi, wo, kLambda)),
                kRounding * bare.pdf(wi, wo, kLambda));
      const auto drawn = coated.sample(wi, kLambda, {0.3, 0.6}), same = bare.sample(wi, kLambda, {0.3, 0.6});
      ASSERT_EQ(drawn.has_value(), same.has_value());
      if (drawn.has_value()) {
        EXPECT_LE((drawn->wo - same->wo).norm(), kRounding);
      }
    }
}

TEST(Coat, RefractsAndComesBack) {
  for (const double n : {1., 1.33, 1.5, 2.4})
    for (const double degrees : {0., 20., 89., 89.999}) {
      const Vec3 w = direction(degrees, 1), inside = detail::refracted(w, n);
      EXPECT_NEAR(inside.norm(), 1, kRounding);
      EXPECT_NEAR(std::hypot(inside.x(), inside.y()) * n, std::hypot(w.x(), w.y()), kRounding);  // Snell
      const auto back = detail::leaving(inside, n);
      ASSERT_TRUE(back);
      EXPECT_LE((*back - w).norm(), 1e-9) << n << ' ' << degrees;
    }
  EXPECT_FALSE(detail::leaving(direction(60), 1.5));  // beyond 41.8 degrees
}

TEST(Coat, IsReciprocal) {
  const Fresnel copper = under(Fresnel(std::complex(0.9, 2.6)), 1.5);
  for (const SunForm form : {SunForm::Corrected, SunForm::AsPrinted})
    for (const double s : {0.1, 1., 20., 1e6}) {
      const Reciprocity found =
          reciprocity(Coated(SunReflection(s, copper, form), {1.5, 100}, form), kLambda);
      EXPECT_LE(found.difference, kRounding) << s << " at " << found.wi.transpose();
    }
  const Microfacet leaning(Ellipsoid({{0.3, -0.1}, 0.3, 0.1, 0.2}), copper);
  EXPECT_LE(reciprocity(Coated(leaning), kLambda).difference, kRounding);
}

TEST(Coat, CorrectedReflectsNoMoreThanComes) {
  constexpr double kTolerance = 1e-2;
  const std::vector<Vec3> directions = {direction(0),  direction(45),   direction(75),
                                        direction(85), direction(89.9), direction(89.999)};
  for (const double n : {1.33, 1.5, 2.4})
    for (const double s : {0.1, 1., 20.})
      for (const double s_top : {20., 1000.})
        EXPECT_LE(white_furnace(Coated(SunReflection(s), {n, s_top}), kLambda, kTolerance, directions).most(),
                  1)
            << n << ' ' << s << ' ' << s_top;
  EXPECT_LE(white_furnace(Coated(Microfacet(ggx(0.3))), kLambda, kTolerance, directions).most(), 1);
}

/// docs/sun.md: 0.04 of the coat and 2.03 = 1.5² × two passages × what the printed substrate has, 0.98.
TEST(Coat, FurnaceOfPrintedFormIsTheDocumentedOne) {
  constexpr double kTolerance = 1e-3, kPrintedDigits = 5e-3;
  EXPECT_NEAR(albedo(printed(20, 1.5, 100), {0, 0, 1}, kLambda, kTolerance).value, 0.04 + 2.03,
              kPrintedDigits);
  const double corrected =
      albedo(Coated(SunReflection(20), {1.5, 100}), {0, 0, 1}, kLambda, kTolerance).value;
  EXPECT_NEAR(corrected, 0.04 + 0.96 * 0.96, kPrintedDigits);
}

TEST(Coat, SamplesFollowTheirDensity) {
  for (const double s : {0.5, 3., 20.})
    for (const double degrees : {5., 70.}) {
      const auto found = testing::test_sampling(Coated(SunReflection(s), {1.5, 20}), direction(degrees, 1),
                                                kLambda, 20000, 3);
      EXPECT_GE(found.p, kLeastP) << s << ' ' << degrees;
      EXPECT_LE(found.largest_mismatch, 1e-9);
      EXPECT_LE(found.integral, 1 + 1e-3);
    }
}

TEST(Coat, ExtremesStayFiniteOrAreRefused) {
  for (const SunForm form : {SunForm::Corrected, SunForm::AsPrinted})
    for (const double n : {1., 1.5, 50.})
      for (const double s : {0.1, 1e6}) {
        const Coated coated(SunReflection(s, Fresnel(), form), {n, 1e6}, form);
        for (const double in : {0., 45., 89.999})
          for (const double out : {0., 45., 89.999}) {
            const double f = coated.f(direction(in), direction(out, std::numbers::pi), kLambda);
            EXPECT_TRUE(f >= 0 && std::isfinite(f)) << n << ' ' << s << ' ' << in << ' ' << out << ' ' << f;
          }
      }
  for (const double n : {0.9, 0., std::nan(""), std::numeric_limits<double>::infinity()})
    EXPECT_THROW(Coated(SunReflection(1), {n, 100}), InputError);
  EXPECT_THROW(Coated(SunReflection(1), {1.5, 0}), InputError);
  EXPECT_THROW(under(Fresnel(Schlick{0.5}), 1.5), InputError);
}

TEST(Coat, ConstantsUnderItAreRelative) {
  const auto index = std::get<std::complex<double>>(under(Fresnel(std::complex(0.9, 2.6)), 1.5).kind());
  EXPECT_NEAR(index.real(), 0.6, kRounding);
  EXPECT_NEAR(index.imag(), 2.6 / 1.5, kRounding);
  const auto table =
      std::get<OpticalConstants>(under(Fresnel(OpticalConstants{{0.5}, {3}, {6}}), 1.5).kind());
  EXPECT_NEAR(table.eta[0], 2, kRounding);
  EXPECT_NEAR(table.kappa[0], 4, kRounding);
  EXPECT_EQ(under(Fresnel(), 1.5)(0.3, kLambda), 1);
}

}  // namespace
}  // namespace micro
