#pragma once

#include <concepts>
#include <optional>

#include "core/grid.h"

namespace micro {

/// A direction drawn for the viewer, with f there (1/sr) and the density it was drawn with (1/sr of wo).
struct BrdfSample {
  Vec3 wo;
  double f, pdf;
};

/// A reflectance model as a value. `wi` points to the light, `wo` to the viewer, unit vectors away from the
/// surface, n = +z; lambda_um is the wavelength in vacuum, µm; `xi` are two uniform numbers in [0, 1).
///   f(wi, wo, lambda_um)       1/sr; 0 where either direction is not above the horizon. No cosine in it
///   sample(wi, lambda_um, xi)  wo with density pdf(wi, wo, lambda_um), positive wherever f is; nothing where
///                              the draw is absorbed, its wo being below the horizon
///   pdf(wi, wo, lambda_um)     1/sr of wo; integrates to one less what is absorbed
template <typename T>
concept Brdf = requires(const T& brdf, const Vec3& wi, const Vec3& wo, double lambda_um, const Vec2& xi) {
  { brdf.f(wi, wo, lambda_um) } -> std::same_as<double>;
  { brdf.sample(wi, lambda_um, xi) } -> std::same_as<std::optional<BrdfSample>>;
  { brdf.pdf(wi, wo, lambda_um) } -> std::same_as<double>;
};

/// The unit half vector of two directions.
inline Vec3 half_vector(const Vec3& wi, const Vec3& wo) {
  return (wi + wo).normalized();
}

/// Where a mirror of unit normal h sends what comes from wi.
inline Vec3 mirrored(const Vec3& wi, const Vec3& h) {
  return 2 * wi.dot(h) * h - wi;
}

}  // namespace micro
