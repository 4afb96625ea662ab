#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "brdf/brdf.h"
#include "core/estimate.h"

namespace micro {

namespace detail {
/// A draw's weight f·cosθ_o/pdf at xi, 0 where it is absorbed.
using SampleWeight = std::function<double(const Vec2& xi)>;
Estimate<double> mean_weight(const SampleWeight& weight, double tolerance);

/// Direction k of a fixed series that is uniform on the hemisphere.
Vec3 random_direction(std::uint64_t k);
Vec2 random_point(std::uint64_t k);
}  // namespace detail

/// The directional albedo ∫ f(wi, wo) cosθ_o dωo: the share of what comes from wi that is reflected. Drawn
/// by the model's own sampling at the points of a lattice, sixteen times with independent shifts, the points
/// doubled until two standard errors of the mean are below `tolerance` (absolute). The error says what was
/// reached: above the tolerance if four million draws were not enough. cost.evaluations counts draws.
template <Brdf Model>
Estimate<double> sampled_albedo(const Model& model, const Vec3& wi, double lambda_um, double tolerance) {
  return detail::mean_weight(
      [&](const Vec2& xi) {
        const auto drawn = model.sample(wi, lambda_um, xi);
        return drawn ? drawn->f * drawn->wo.z() / drawn->pdf : 0;
      },
      tolerance);
}

/// The same by the model's own integral where it has one, `model.albedo(…)`, whose cost counts evaluations.
template <Brdf Model>
Estimate<double> albedo(const Model& model, const Vec3& wi, double lambda_um, double tolerance) {
  if constexpr (requires { model.albedo(wi, lambda_um, tolerance); })
    return model.albedo(wi, lambda_um, tolerance);
  else
    return sampled_albedo(model, wi, lambda_um, tolerance);
}

/// Albedos that ask whether a model makes energy: of light from all round, none must be above one.
struct WhiteFurnace {
  std::vector<Vec3> wi;
  std::vector<Estimate<double>> albedo;

  /// The largest albedo less its error: above one, the model makes energy.
  double most() const;
};

/// Directions from the normal to 89.999 degrees at four azimuths.
std::vector<Vec3> furnace_directions();

template <Brdf Model>
WhiteFurnace white_furnace(const Model& model, double lambda_um, double tolerance,
                           const std::vector<Vec3>& directions = furnace_directions()) {
  WhiteFurnace furnace{directions, {}};
  for (const Vec3& wi : directions)
    furnace.albedo.push_back(albedo(model, wi, lambda_um, tolerance));
  return furnace;
}

/// Where f(wi, wo) and f(wo, wi) differ most: |difference| over the larger of the two.
struct Reciprocity {
  double difference = 0;
  Vec3 wi = {0, 0, 1}, wo = {0, 0, 1};
};

/// Over `pairs` directions wi uniform on the hemisphere; wo is uniform too, then drawn by the model. Below
/// 1e-280 numbers lose their digits: there both count as the same. A value that is not a number comes back as
/// a difference that is none.
template <Brdf Model>
Reciprocity reciprocity(const Model& model, double lambda_um, int pairs = 1000) {
  Reciprocity worst;
  constexpr double kNothing = 1e-280;
  const auto compare = [&](const Vec3& wi, const Vec3& wo) {
    const double there = model.f(wi, wo, lambda_um), back = model.f(wo, wi, lambda_um);
    if (std::abs(there) < kNothing && std::abs(back) < kNothing) return;
    const double difference = std::abs(there - back) / std::max(std::abs(there), std::abs(back));
    if (!(difference <= worst.difference)) worst = {difference, wi, wo};
  };
  for (int k = 0; k < pairs; ++k) {
    const auto index = static_cast<std::uint64_t>(k);
    const Vec3 wi = detail::random_direction(2 * index);
    compare(wi, detail::random_direction(2 * index + 1));
    if (const auto drawn = model.sample(wi, lambda_um, detail::random_point(index))) compare(wi, drawn->wo);
  }
  return worst;
}

}  // namespace micro
