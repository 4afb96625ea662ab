#pragma once

#include <algorithm>

#include "brdf/brdf.h"
#include "brdf/fresnel.h"
#include "distribution/distribution.h"

namespace micro {

/// The microfacet model, geometric optics of single reflections [Dong15 Eqs. 1, 13]:
/// f = D(h) F(wi·h) G1(wi) G1(wo)/(4 |wi·n| |wo·n|), with the distribution's own G1, masking and shadowing
/// being taken as independent. Samples follow the normals visible from wi: each weighs F·G1(wo) at most.
template <Distribution Normals>
class Microfacet {
 public:
  explicit Microfacet(Normals normals, Fresnel fresnel = Fresnel())
      : normals_(std::move(normals)), fresnel_(std::move(fresnel)) {}

  const Normals& normals() const { return normals_; }
  const Fresnel& fresnel() const { return fresnel_; }

  double f(const Vec3& wi, const Vec3& wo, double lambda_um) const {
    const double without = without_fresnel(wi, wo);
    return without > 0 ? without * fresnel_(wi.dot(half_vector(wi, wo)), lambda_um) : 0;
  }

  /// D G/(4 |wi·n| |wo·n|), the part that all wavelengths share.
  double without_fresnel(const Vec3& wi, const Vec3& wo) const {
    if (!(wi.z() > 0 && wo.z() > 0)) return 0;
    return normals_.D(half_vector(wi, wo)) * (normals_.G1(wi) / wi.z()) * (normals_.G1(wo) / wo.z()) / 4;
  }

  std::optional<BrdfSample> sample(const Vec3& wi, double lambda_um, const Vec2& xi) const {
    if (!(wi.z() > 0)) return std::nullopt;
    const Vec3 wo = mirrored(wi, normals_.sample_visible(wi, xi));
    const double density = pdf(wi, wo, lambda_um);
    if (!(density > 0)) return std::nullopt;
    return BrdfSample{wo, f(wi, wo, lambda_um), density};
  }

  double pdf(const Vec3& wi, const Vec3& wo, double /*lambda_um*/) const {
    if (!(wi.z() > 0 && wo.z() > 0)) return 0;
    const Vec3 h = half_vector(wi, wo);
    const double cosine = wi.dot(h);
    return cosine > 0 ? normals_.pdf_visible(wi, h) / (4 * cosine) : 0;
  }

 private:
  Normals normals_;
  Fresnel fresnel_;
};

}  // namespace micro
