#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "brdf/brdf.h"
#include "core/random.h"
#include "testing/chi_square.h"

namespace micro::testing {

/// The direction at polar angle and azimuth; its cosine keeps its digits at grazing angles.
inline Vec3 direction(double degrees, double azimuth_rad = 0) {
  const double theta = degrees * std::numbers::pi / 180, beside = (90 - degrees) * std::numbers::pi / 180;
  return {std::sin(theta) * std::cos(azimuth_rad), std::sin(theta) * std::sin(azimuth_rad), std::sin(beside)};
}

/// What the draws of a BRDF say of its density.
struct SamplingTest {
  double p;                 ///< of χ² over bins of wo and what is absorbed
  double integral;          ///< ∫ pdf dω by the midpoint rule
  double largest_mismatch;  ///< of the sample's own f and pdf against the functions, relative
};

/// `draws` samples from wi in bins equal in cosθ_o and azimuth against the pdf's integral over them; the lobe
/// must be wider than a 256th of the one and a 512th of the other.
template <Brdf Model>
SamplingTest test_sampling(const Model& model, const Vec3& wi, double lambda_um, int draws,
                           std::uint64_t seed) {
  constexpr int kCosines = 16, kAzimuths = 32, kSteps = 16;
  constexpr auto kBins = static_cast<std::size_t>(kCosines * kAzimuths);
  std::vector<double> counts(kBins + 1), expected(kBins + 1);
  double mismatch = 0;
  for (int k = 0; k < draws; ++k) {
    const auto [x, y] = random_uniform(seed, 0, static_cast<std::uint64_t>(k));
    const auto drawn = model.sample(wi, lambda_um, {x, y});
    if (!drawn) {
      ++counts[kBins];
      continue;
    }
    const double turn = std::atan2(drawn->wo.y(), drawn->wo.x()) / (2 * std::numbers::pi) + 0.5;
    const int i = std::min(kAzimuths - 1, static_cast<int>(turn * kAzimuths)),
              j = std::min(kCosines - 1, static_cast<int>(drawn->wo.z() * kCosines));
    ++counts[static_cast<std::size_t>(j * kAzimuths + i)];
    mismatch = std::max({mismatch, std::abs(drawn->pdf / model.pdf(wi, drawn->wo, lambda_um) - 1),
                         std::abs(drawn->f - model.f(wi, drawn->wo, lambda_um)) / (drawn->f + 1e-300)});
  }
  double integral = 0;
  const double cell = 2 * std::numbers::pi / (kCosines * kSteps * kAzimuths * kSteps);
  for (int j = 0; j < kCosines * kSteps; ++j)
    for (int i = 0; i < kAzimuths * kSteps; ++i) {
      const double z = (j + 0.5) / (kCosines * kSteps), sine = std::sqrt(1 - z * z);
      const double phi = 2 * std::numbers::pi * ((i + 0.5) / (kAzimuths * kSteps) - 0.5);
      const double mass = model.pdf(wi, {sine * std::cos(phi), sine * std::sin(phi), z}, lambda_um) * cell;
      expected[static_cast<std::size_t>(j / kSteps * kAzimuths + i / kSteps)] += mass * draws;
      integral += mass;
    }
  // What is not drawn is what the density lacks; when that is everything but rounding, nothing is expected
  // there.
  expected[kBins] = std::max(0., draws * (1 - integral));
  return {chi_square_p(counts, expected), integral, mismatch};
}

}  // namespace micro::testing
