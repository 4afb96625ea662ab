#include "brdf/microfacet.h"

#include <gtest/gtest.h>

#include <numbers>

#include "brdf/albedo.h"
#include "distribution/beckmann.h"
#include "distribution/ellipsoid.h"

namespace micro {
namespace {

constexpr double kRounding = 1e-13;
constexpr double kLambda = 0.55;

static_assert(Brdf<Microfacet<Ellipsoid>>);

/// Widths from polished to bristling, round, brushed and leaning.
std::vector<SlopeFrame> frames() {
  return {{{0, 0}, 1e-4, 0, 1e-4}, {{0, 0}, 0.01, 0, 0.01},      {{0, 0}, 0.2, 0, 0.2},
          {{0, 0}, 0.5, 0, 0.05},  {{0.3, -0.1}, 0.3, 0.1, 0.2}, {{0, 0}, 1, 0, 1},
          {{0, 0}, 10, 0, 10},     {{2, 0}, 0.2, 0, 0.1}};
}

template <typename Lobe>
class MicrofacetModels : public ::testing::Test {};
using Lobes = ::testing::Types<Ellipsoid, Beckmann>;
TYPED_TEST_SUITE(MicrofacetModels, Lobes);

TYPED_TEST(MicrofacetModels, AreReciprocal) {
  for (const SlopeFrame& frame : frames()) {
    const Reciprocity found =
        reciprocity(Microfacet(TypeParam(frame), Fresnel(std::complex(0.2, 3.))), kLambda);
    EXPECT_LE(found.difference, kRounding) << frame.l11 << " at " << found.wi.transpose();
  }
}

TYPED_TEST(MicrofacetModels, ReflectNoMoreThanComes) {
  constexpr double kTolerance = 1e-2;
  for (const SlopeFrame& frame : frames())
    EXPECT_LE(white_furnace(Microfacet(TypeParam(frame)), kLambda, kTolerance).most(), 1) << frame.l11;
}

/// GGX as [Walter07 Eqs. 20, 33, 34] print it: in tan θ of the half vector and of the directions.
double walter07(double alpha, const Vec3& wi, const Vec3& wo) {
  const Vec3 h = half_vector(wi, wo);
  const auto tangent2 = [](const Vec3& u) { return (1 - u.z() * u.z()) / (u.z() * u.z()); };
  const double a2 = alpha * alpha;
  const double d = a2 / (std::numbers::pi * std::pow(h.z(), 4) * std::pow(a2 + tangent2(h), 2));
  const auto g1 = [&](const Vec3& u) { return 2 / (1 + std::sqrt(1 + a2 * tangent2(u))); };
  return d * g1(wi) * g1(wo) / (4 * wi.z() * wo.z());
}

TEST(MicrofacetGgx, IsThatOfItsPaper) {
  constexpr double kFormula = 1e-11;  // of the printed form, which cancels in 1 − cos²
  for (const double alpha : {0.05, 0.3, 1.})
    for (std::uint64_t k = 0; k < 100; ++k) {
      const Vec3 wi = detail::random_direction(2 * k), wo = detail::random_direction(2 * k + 1);
      const double expected = walter07(alpha, wi, wo);
      EXPECT_NEAR(Microfacet(ggx(alpha)).f(wi, wo, kLambda) / expected, 1, kFormula);
    }
  // Along the normal f = F/(4πα²).
  const Vec3 n(0, 0, 1);
  EXPECT_NEAR(Microfacet(ggx(0.5), Fresnel(Schlick{0.6})).f(n, n, kLambda), 0.6 / std::numbers::pi,
              kRounding);
}

TYPED_TEST(MicrofacetModels, StayFiniteAtTheExtremes) {
  const double grazing = std::sin(0.001 * std::numbers::pi / 180);  // 89.999 degrees
  const std::vector<Fresnel> interfaces = {Fresnel(std::complex(1., 0.)), Fresnel(std::complex(1.5, 0.)),
                                           Fresnel(std::complex(1., 50.)), Fresnel()};
  for (const SlopeFrame& frame : frames())
    for (const Fresnel& interface : interfaces) {
      const Microfacet model(TypeParam(frame), interface);
      for (const double z : {1., 0.5, grazing})
        for (const double turn : {1., -1.}) {
          const Vec3 wi(std::sqrt(1 - z * z), 0, z), wo(turn * std::sqrt(1 - grazing * grazing), 0, grazing);
          const double f = model.f(wi, wo, kLambda);
          EXPECT_TRUE(std::isfinite(f) && f >= 0) << frame.l11 << " " << z << ": " << f;
          if (const auto drawn = model.sample(wi, kLambda, {0.3, 0.7})) {
            EXPECT_TRUE(std::isfinite(drawn->f / drawn->pdf)) << frame.l11 << " " << z;
          }
        }
    }
}

}  // namespace
}  // namespace micro
