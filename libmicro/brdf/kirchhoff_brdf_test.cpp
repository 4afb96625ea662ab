#include "brdf/kirchhoff_brdf.h"

#include <gtest/gtest.h>

#include "brdf/albedo.h"
#include "brdf/any_brdf.h"
#include "core/error.h"
#include "core/random.h"
#include "distribution/beckmann.h"
#include "distribution/tabulate.h"
#include "height/gaussian_surface.h"
#include "kirchhoff/exact.h"
#include "kirchhoff/kirchhoff_volume.h"
#include "testing/kirchhoff_ensemble.h"

namespace micro {
namespace {

constexpr double kLambda = 0.55, kRounding = 1e-13;

Vec3 direction(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

/// ⟨D_K⟩ of Gaussian surfaces; nothing comes from below.
auto ensemble(const testing::GaussianStatistics& statistics) {
  return
      [statistics](const Vec3& q) { return q.z() > 0 ? testing::gaussian_mean_density(q, statistics) : 0; };
}

TEST(KirchhoffBrdfs, WaveLengthOfTheHalfAngle) {
  const Vec3 wi = direction(0.7, 0.2), wo = direction(0.4, 2);
  const double theta_d = std::acos(wi.dot(wo));
  EXPECT_NEAR(wavelength_q(kLambda, wi, wo), kLambda / std::cos(theta_d / 2), kRounding);
  const Vec3 q = momentum(kLambda, wi, wo);
  EXPECT_NEAR(q.norm(), 4 * std::numbers::pi / wavelength_q(kLambda, wi, wo), 1e-12);
  EXPECT_LE((q.normalized() - half_vector(wi, wo)).norm(), kRounding);
}

/// A surface many wavelengths rough scatters as its facets do: the first correction is of order 1/g, g =
/// q_z²σ².
TEST(KirchhoffBrdfs, RoughSurfacesReflectAsTheirFacets) {
  const testing::GaussianStatistics rough{3, 40, 40};
  const Vec2 alpha = testing::slope_alpha(rough);
  const Beckmann facets({{0, 0}, alpha.x(), 0, alpha.y()});
  const Microfacet geometric(facets, Fresnel(std::complex(0.3, 3.)));
  const KirchhoffBrdf wave(ensemble(rough), facets, Masking::Smith, geometric.fresnel());
  for (const double theta : {0., 0.5, 1.})
    for (const double turn : {-0.2, 0., 0.15}) {
      const Vec3 wi = direction(theta, 0), wo = direction(theta + turn, std::numbers::pi);
      const double qz = momentum(kLambda, wi, wo).z(), g = qz * qz * rough.sigma * rough.sigma;
      const double exponent = std::pow(slope_of(half_vector(wi, wo)).norm() / alpha.x(), 2);
      EXPECT_NEAR(wave.f(wi, wo, kLambda) / geometric.f(wi, wo, kLambda), 1,
                  2 * (1 + exponent * exponent) / g);
    }
}

TEST(KirchhoffBrdfs, DensityComesBackFromReflectance) {
  const testing::GaussianStatistics surface{0.3, 5, 5};
  const Vec3 wi = direction(0.5, 0), wo = direction(0.3, 2.5);
  const KirchhoffBrdf wave(ensemble(surface), gaussian_surface_normals({0.3, 5, 5}), Masking::None,
                           Fresnel(std::complex(0.3, 3.)));
  const double reflected = fresnel(wi.dot(half_vector(wi, wo)), {0.3, 3});
  const double density = testing::gaussian_mean_density(momentum(kLambda, wi, wo), surface);
  EXPECT_NEAR(density_from_reflectance(wave.f(wi, wo, kLambda), reflected, wi, wo) / density, 1, kRounding);
}

TEST(KirchhoffBrdfs, VolumeOfASurfaceIsItsExactDensity) {
  constexpr double kInterpolated = 5e-3;  // of the root mean square of D
  const HeightField surface = gaussian_surface({24, 24, 0.25, 0.25}, {0.1, 2, 2, 0}, 3);
  const double q_max = 4 * std::numbers::pi / kLambda;
  const auto volume = std::make_shared<DensityVolume>(kirchhoff_volume(surface, 0.6 * q_max, q_max, 1e-4));
  const Beckmann normals = gaussian_surface_normals({0.1, 2, 2});
  const KirchhoffBrdf wave(VolumeDensity(volume), normals, Masking::Smith, Fresnel());
  EXPECT_LE(reciprocity(wave, kLambda, 200).difference, kRounding);
  double square = 0, difference = 0;
  for (std::uint64_t k = 0; k < 60; ++k) {
    const auto [a, b] = random_uniform(8, 0, k);
    const Vec3 wi = direction(0.6 * a, 6 * b);
    const Vec3 wo = mirrored(wi, normals.sample({random_uniform(8, 1, k)[0], random_uniform(8, 1, k)[1]}));
    if (!(wo.z() > 0.3)) continue;
    const double seen = normals.G1(wi) * normals.G1(wo);
    const double found = density_from_reflectance(wave.f(wi, wo, kLambda), 1, wi, wo) / seen;
    const double exact = exact_density(surface, momentum(kLambda, wi, wo));
    square += exact * exact;
    difference += (found - exact) * (found - exact);
  }
  EXPECT_GT(square, 0);
  EXPECT_LE(std::sqrt(difference / square), kInterpolated);
  // Beyond the volume nothing is known.
  EXPECT_EQ(wave.f(direction(1.4, 0), direction(1.3, 0), kLambda), 0);
}

/// Without G the waves that miss the surface are counted: energy is made at grazing angles; with it none is.
TEST(KirchhoffBrdfs, MaskingKeepsTheFurnaceBelowOne) {
  constexpr double kTolerance = 1e-2;
  const testing::GaussianStatistics surface{0.5, 4, 4};
  const Beckmann normals = gaussian_surface_normals({0.5, 4, 4});
  const std::vector<Vec3> directions = {direction(0, 0), direction(0.8, 0), direction(1.5, 0)};
  const auto most = [&](Masking masking) {
    return white_furnace(KirchhoffBrdf(ensemble(surface), normals, masking), kLambda, kTolerance, directions)
        .most();
  };
  EXPECT_LE(most(Masking::Smith), 1.01);
  EXPECT_GT(most(Masking::None), 1.05);
}

TEST(SpectrumDensities, LieBetweenTheirTables) {
  const auto table = [](double alpha) {
    return Tabulated(tabulate(Beckmann({{0, 0}, alpha, 0, alpha}), {257, 1}));
  };
  const Tabulated narrow = table(0.1), wide = table(0.2);
  const SpectrumDensity density({0.4, 0.8}, {narrow, wide});
  const Vec3 m = direction(0.15, 1);
  const auto at = [&](double lambda_q) { return density(4 * std::numbers::pi / lambda_q * m); };
  EXPECT_NEAR(at(0.3), narrow.D(m), 1e-12);
  EXPECT_NEAR(at(0.4), narrow.D(m), 1e-10);
  EXPECT_NEAR(at(1.6 / 3), (narrow.D(m) + wide.D(m)) / 2, 1e-10);  // half way in 1/λ_q
  EXPECT_NEAR(at(2), wide.D(m), 1e-12);
  EXPECT_THROW(SpectrumDensity({0.8, 0.4}, {narrow, wide}), InputError);
  EXPECT_THROW(SpectrumDensity({}, {}), InputError);
}

/// Two speckled tables of lobes 0.2 wide: nodes between a tenth and twice the lobe's value.
SpectrumDensity speckled_spectrum(double medium) {
  std::vector<Tabulated> tables;
  for (const std::uint32_t stream : {0u, 1u}) {
    DiskTable table = tabulate(Beckmann({{0, 0}, 0.2, 0, 0.2}), {129, 1});
    for (Eigen::Index k = 0; k < table.density.size(); ++k)
      table.density.data()[k] *= 0.1 + 1.9 * random_uniform(3, stream, static_cast<std::uint64_t>(k))[0];
    tables.emplace_back(table);
  }
  return SpectrumDensity({0.4, 0.8}, tables, medium);
}

TEST(KirchhoffBrdfs, AlbedoOverTheTablesIsThatOfDraws) {
  constexpr double kTolerance = 2e-3;
  const Beckmann normals({{0, 0}, 0.2, 0, 0.2});
  for (const Masking masking : {Masking::Smith, Masking::None}) {
    const KirchhoffBrdf wave(speckled_spectrum(1), normals, masking, Fresnel(std::complex(0.3, 3.)));
    for (const double theta : {0., 0.9, 1.5}) {
      const Vec3 wi = direction(theta, 1);
      const Estimate<double> tables = albedo(wave, wi, kLambda, kTolerance);
      const Estimate<double> draws = sampled_albedo(wave, wi, kLambda, kTolerance);
      EXPECT_LE(tables.error, kTolerance);
      EXPECT_NEAR(tables.value, draws.value, kTolerance + 2 * draws.error) << theta;
      EXPECT_EQ(albedo(AnyBrdf(wave), wi, kLambda, kTolerance).value, tables.value);
    }
  }
}

/// Light in glass is shorter: it sees the tables of 0.55 µm where that of 0.55·1.5 µm comes into it.
TEST(KirchhoffBrdfs, MediumShortensTheLight) {
  const Beckmann normals({{0, 0}, 0.2, 0, 0.2});
  const KirchhoffBrdf air(speckled_spectrum(1), normals, Masking::Smith),
      glass(speckled_spectrum(1.5), normals, Masking::Smith);
  const Vec3 wi = direction(0.5, 0), wo = direction(0.45, 3);
  EXPECT_NEAR(glass.f(wi, wo, 1.5 * kLambda) / air.f(wi, wo, kLambda), 1, kRounding);
  EXPECT_NEAR(albedo(glass, wi, 1.5 * kLambda, 1e-3).value, albedo(air, wi, kLambda, 1e-3).value, 1e-9);
}

}  // namespace
}  // namespace micro
