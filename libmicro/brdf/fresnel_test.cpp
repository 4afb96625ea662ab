#include "brdf/fresnel.h"

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <boost/multiprecision/cpp_complex.hpp>

#include "brdf/metals.h"
#include "core/error.h"

namespace micro {
namespace {

constexpr double kRounding = 1e-13;
using Many = boost::multiprecision::cpp_bin_float_50;
using ManyComplex = boost::multiprecision::cpp_complex_50;

/// Fresnel's amplitudes by Snell's law, with fifty digits.
double reference(double cosine, double eta, double kappa) {
  const ManyComplex n(eta, kappa), ci(cosine, 0);
  const ManyComplex ct = sqrt(ManyComplex(1) - (ManyComplex(1) - ci * ci) / (n * n));
  const ManyComplex s = (ci - n * ct) / (ci + n * ct), p = (n * ci - ct) / (n * ci + ct);
  return static_cast<double>(Many((norm(s).real() + norm(p).real()) / 2));
}

TEST(FresnelEquations, AreThoseOfFiftyDigits) {
  for (const double eta : {0.04, 0.3, 0.999, 1., 1.5, 4., 20.})
    for (const double kappa : {0., 1e-8, 0.1, 3., 50.}) {
      if (eta < 1 && kappa == 0) continue;  // where Snell's root is on its cut
      for (const double degrees : {0., 30., 60., 89., 89.9, 89.999}) {
        const double cosine = std::cos(degrees * 0x1.921fb54442d18p+1 / 180);
        const double expected = reference(cosine, eta, kappa);
        EXPECT_NEAR(fresnel(cosine, {eta, kappa}), expected, kRounding)
            << eta << " + i" << kappa << " at " << degrees;
      }
    }
}

TEST(FresnelEquations, EndsAreRight) {
  EXPECT_EQ(fresnel(0, {0.2, 3}), 1);                           // grazing
  EXPECT_EQ(fresnel(0.3, {1, 0}), 0);                           // nothing there
  EXPECT_LE(fresnel(1e-5, {1, 0}), 1e-30);                      // and still nothing at 89.999 degrees
  EXPECT_NEAR(fresnel_dielectric(1, 1.5), 0.04, kRounding);     // ((n − 1)/(n + 1))²
  EXPECT_NEAR(fresnel_dielectric(0.5, 1 / 1.5), 1, kRounding);  // total reflection at 60 degrees
  EXPECT_NEAR(fresnel_schlick(0.5, 0.04), 0.04 + 0.96 / 32, kRounding);
  // Brewster's angle: nothing of the parallel half, of the other ((n² − 1)/(n² + 1))².
  const double n = 1.5, half = (n * n - 1) / (n * n + 1);
  EXPECT_NEAR(fresnel_dielectric(1 / std::hypot(1, n), n), half * half / 2, kRounding);
}

TEST(FresnelEquations, ExtinctionGivesTheReflectanceBack) {
  for (const double eta : {0.2, 1., 2.5})
    for (const double r0 : {0.6, 0.9, 0.999})
      EXPECT_NEAR(fresnel(1, {eta, extinction_from_r0(eta, r0)}), r0, kRounding);
  EXPECT_EQ(extinction_from_r0(1, 0), 0);
  EXPECT_THROW(extinction_from_r0(1.5, 0.01), InputError);
  EXPECT_THROW(extinction_from_r0(1.5, 1), InputError);
}

TEST(FresnelValues, RefuseWhatIsNoMaterial) {
  EXPECT_THROW(Fresnel(std::complex<double>(0, 1)), InputError);
  EXPECT_THROW(Fresnel(std::complex<double>(1, -1)), InputError);
  EXPECT_THROW(Fresnel(Schlick{1.5}), InputError);
  EXPECT_THROW(Fresnel(OpticalConstants{{0.5, 0.4}, {1, 1}, {0, 0}}), InputError);
  EXPECT_THROW(Fresnel(metal("Cu").constants)(1, 0.2), InputError);
  EXPECT_THROW(metal("Xx"), InputError);
}

/// Reflectances at 0.55 µm as computed from the printed (η, κ) near that wavelength.
TEST(Metals, ReflectAsPublished) {
  constexpr double kInterpolation = 0.01;
  const std::vector<std::pair<const char*, double>> published = {
      {"Al", 0.916}, {"Ag", 0.984}, {"Fe", 0.512}, {"Cr", 0.554}, {"Ni", 0.640}};
  for (const auto& [name, r0] : published)
    EXPECT_NEAR(Fresnel(metal(name).constants)(1, 0.549), r0, kInterpolation) << name;
  for (const Metal& each : metals())
    for (double lambda = 0.36; lambda <= 0.83; lambda += 0.01) {
      const double r = fresnel(1, each.constants.at(lambda));
      EXPECT_GT(r, 0.2) << each.name << lambda;
      EXPECT_LT(r, 1) << each.name << lambda;
    }
}

}  // namespace
}  // namespace micro
