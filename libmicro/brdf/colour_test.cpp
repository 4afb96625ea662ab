#include "brdf/colour.h"

#include <gtest/gtest.h>

#include "brdf/metals.h"
#include "core/error.h"
#include "core/random.h"

namespace micro {
namespace {

/// Linear sRGB of a smooth metal seen along its normal.
Vec3 colour_of(const std::string& name, int wavelengths) {
  const ColourWeights weights(visible_wavelengths(wavelengths));
  std::vector<double> reflectance;
  for (const double lambda : weights.lambda_um())
    reflectance.push_back(fresnel(1, metal(name).constants.at(lambda)));
  return linear_srgb(weights.xyz(reflectance));
}

TEST(Colour, WhiteIsD65) {
  const Vec3 white = white_point();  // CIE 15:2004: x = 0.31272, y = 0.32903
  constexpr double kFiveNanometres = 5e-5;
  EXPECT_NEAR(white.x() / white.sum(), 0.31272, kFiveNanometres);
  EXPECT_NEAR(white.y() / white.sum(), 0.32903, kFiveNanometres);
}

TEST(Colour, MatrixIsThatOfTheStandard) {
  // IEC 61966-2-1 prints four digits, for the white (0.3127, 0.3290).
  constexpr double kDigits = 6e-4;
  const Vec3 red = xyz_of_linear_srgb({1, 0, 0}), green = xyz_of_linear_srgb({0, 1, 0});
  EXPECT_LE((red - Vec3(0.4124, 0.2126, 0.0193)).cwiseAbs().maxCoeff(), kDigits);
  EXPECT_LE((green - Vec3(0.3576, 0.7152, 0.1192)).cwiseAbs().maxCoeff(), kDigits);
  EXPECT_LE((linear_srgb(white_point()) - Vec3(1, 1, 1)).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(Colour, TransferFunctionIsThatOfTheStandard) {
  EXPECT_NEAR(srgb_encoded(0.18), 0.461356, 1e-6);
  for (const double x : {0., 0.002, 0.0031308, 0.2, 1.})
    EXPECT_NEAR(srgb_decoded(srgb_encoded(x)), x, 1e-7);
}

/// Colours that others computed from the same (η, κ), the CIE's observer and D65, printed to three digits:
/// Cu, Fe and Ni of the Physically Based database (physicallybased.info), Cu, Ag, Au and Fe of f0.py in
/// stoatworks-labs/repousse. What is left is the interpolation between (η, κ).
TEST(Colour, MetalsAreThoseThatOthersComputeFromTheSameConstants) {
  constexpr double kDigits = 1.1e-3;
  const std::vector<std::pair<std::string, Vec3>> published = {
      {"Cu", {0.932, 0.623, 0.522}}, {"Ag", {0.989, 0.984, 0.977}}, {"Au", {1.038, 0.728, 0.365}},
      {"Fe", {0.530, 0.513, 0.494}}, {"Ni", {0.697, 0.641, 0.563}}, {"steel", {0.669, 0.639, 0.598}}};
  for (const auto& [name, rgb] : published)
    EXPECT_LE((colour_of(name, 95) - rgb).cwiseAbs().maxCoeff(), kDigits)
        << name << ": " << colour_of(name, 95).transpose();
}

/// Colours from other measurements: linear sRGB from Palik's (η, κ) [Lagarde 2011, "Feeding a physically
/// based shading model"] and, for Ag and Al, of Adobe's "Metal material references" (Standard Material). How
/// far apart two measurements of one metal lie is the tolerance of each: most for the blue of Lagarde's
/// silver.
TEST(Colour, MetalsAreNearThoseOfOtherMeasurements) {
  struct Published {
    std::string name;
    Vec3 rgb;
    double apart;
  };
  const std::vector<Published> published = {
      {"Al", {0.913, 0.921, 0.925}, 0.01},  {"Al", {0.9157, 0.9226, 0.9236}, 0.01},
      {"Ag", {0.972, 0.960, 0.915}, 0.065}, {"Ag", {0.9868, 0.9830, 0.9667}, 0.015},
      {"Au", {1.000, 0.766, 0.336}, 0.04},  {"Cu", {0.955, 0.637, 0.538}, 0.025}};
  for (const auto& [name, rgb, apart] : published)
    EXPECT_LE((colour_of(name, 95) - rgb).cwiseAbs().maxCoeff(), apart)
        << name << ": " << colour_of(name, 95).transpose();
}

TEST(Colour, GreysAreGreyForAnyWavelengths) {
  for (const int n : {1, 2, 3, 7, 40})
    EXPECT_LE((linear_srgb(ColourWeights(visible_wavelengths(n))
                               .xyz(std::vector<double>(static_cast<std::size_t>(n), 0.4))) -
               Vec3::Constant(0.4))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-14);
  EXPECT_THROW(ColourWeights({0.5, 0.4}), InputError);
  EXPECT_THROW(ColourWeights({}), InputError);
}

TEST(Colour, MoreWavelengthsComeNearer) {
  const Vec3 all = colour_of("Cu", 95);
  EXPECT_LE((colour_of("Cu", 16) - all).cwiseAbs().maxCoeff(), 0.01);
  EXPECT_LE((colour_of("Cu", 32) - all).cwiseAbs().maxCoeff(), 0.003);
}

TEST(SmoothReflectances, GiveBackTheirColour) {
  constexpr double kConverged = 1e-6, kCorner = 1e-2;
  const ColourWeights weights(visible_wavelengths(200));
  for (std::uint64_t k = 0; k < 200; ++k) {
    const auto [r, g] = random_uniform(3, 0, k);
    const Vec3 rgb = Vec3(r, g, random_uniform(3, 1, k)[0]);
    const SmoothReflectance smooth = smooth_reflectance(0.05 * Vec3::Ones() + 0.9 * rgb);
    EXPECT_LE(smooth.error, kConverged) << rgb.transpose();
  }
  for (int corner = 0; corner < 8; ++corner) {
    const SmoothReflectance smooth = smooth_reflectance(Vec3(corner & 1, corner >> 1 & 1, corner >> 2));
    EXPECT_LE(smooth.error, kCorner) << corner;
    for (const double lambda : weights.lambda_um()) {
      EXPECT_GE(smooth(lambda), 0);
      EXPECT_LE(smooth(lambda), 1);
    }
  }
  EXPECT_THROW(smooth_reflectance({0.5, 1.2, 0}), InputError);
}

}  // namespace
}  // namespace micro
