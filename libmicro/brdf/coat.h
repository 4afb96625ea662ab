#pragma once

#include "brdf/sun.h"

namespace micro {

/// A smooth transparent coat [SunGlossy]: index n ≥ 1 over vacuum, its upper face a Gaussian surface of
/// smoothness s = τ/σ_h.
struct Coat {
  double n = 1.5;
  double smoothness = 1000;
};

/// The reflectance of an interface that lies under a medium of index n: its optical constants are divided by
/// n [Sun02 §5.2, "relative to medium 1"]. A perfect mirror stays one; throws InputError for Schlick's
/// approximation, which has no constants.
Fresnel under(const Fresnel& fresnel, double n);

namespace detail {
/// Throws InputError unless n ≥ 1 and finite.
void check_coat(const Coat& coat);
/// The direction inside a flat coat of what comes from w [SunGlossy Eq. 7], and back: nothing where all is
/// reflected inside.
Vec3 refracted(const Vec3& w, double n);
std::optional<Vec3> leaving(const Vec3& inside, double n);
}  // namespace detail

/// A substrate of any kind under a thin coat that neither absorbs nor, as the paper has it, reflects light
/// back to the substrate [SunGlossy Eqs. 1–10]:
///   f = ρ₁(wi, wo) + T(θ_i)T(θ_o)·f_s(wi', wo')/n², T = 1 − F
/// with directions inside by Snell's law and F that of the flat coat. The substrate lies in the coat: its own
/// Fresnel reflectance is the caller's, `under(fresnel, n)`.
///   Corrected: 1/n², because a solid angle dω cosθ outside is n² times dω' cosθ' inside: radiance is spread;
///              ρ₁ is the microfacet form with Smith's masking, without which it reflects more than all at
///              grazing angles
///   AsPrinted: no 1/n²; ρ₁ = F·p/(4 cos³θ cos(δ/2)) without masking [Eq. 2]
/// Samples choose the upper face with probability F, else the substrate; what is reflected inside is
/// absorbed.
template <Brdf Substrate>
class Coated {
 public:
  /// Throws InputError unless n ≥ 1 and s > 0, finite.
  explicit Coated(Substrate substrate, const Coat& coat = {}, SunForm form = SunForm::Corrected)
      : substrate_(std::move(substrate)),
        coat_(coat),
        form_(form),
        top_normals_(normals_of_smoothness(coat.smoothness)) {
    detail::check_coat(coat);
  }

  const Substrate& substrate() const { return substrate_; }
  const Coat& coat() const { return coat_; }

  double f(const Vec3& wi, const Vec3& wo, double lambda_um) const {
    if (!(wi.z() > 0 && wo.z() > 0)) return 0;
    const double spread = form_ == SunForm::Corrected ? 1 / (coat_.n * coat_.n) : 1;
    const double through = (1 - reflectance(wi.z())) * (1 - reflectance(wo.z()));
    return top(wi, wo) +
           through * spread *
               substrate_.f(detail::refracted(wi, coat_.n), detail::refracted(wo, coat_.n), lambda_um);
  }

  std::optional<BrdfSample> sample(const Vec3& wi, double lambda_um, const Vec2& xi) const {
    if (!(wi.z() > 0)) return std::nullopt;
    const double first = reflectance(wi.z());
    const std::optional<Vec3> wo =
        xi.x() < first
            ? std::optional(mirrored(wi, top_normals_.sample_visible(wi, {xi.x() / first, xi.y()})))
            : from_below(wi, lambda_um, {(xi.x() - first) / (1 - first), xi.y()});
    if (!wo || !(wo->z() > 0)) return std::nullopt;
    const double density = pdf(wi, *wo, lambda_um);
    if (!(density > 0)) return std::nullopt;
    return BrdfSample{*wo, f(wi, *wo, lambda_um), density};
  }

  double pdf(const Vec3& wi, const Vec3& wo, double lambda_um) const {
    if (!(wi.z() > 0 && wo.z() > 0)) return 0;
    const double first = reflectance(wi.z());
    const Vec3 inside = detail::refracted(wo, coat_.n);
    const double solid_angle = wo.z() / (coat_.n * coat_.n * inside.z());  // dω'/dω
    const double below = substrate_.pdf(detail::refracted(wi, coat_.n), inside, lambda_um) * solid_angle;
    if (!(first > 0)) return below;
    const Vec3 h = half_vector(wi, wo);
    return first * top_normals_.pdf_visible(wi, h) / (4 * wi.dot(h)) + (1 - first) * below;
  }

 private:
  /// Of the flat coat.
  double reflectance(double cosine) const { return coat_.n > 1 ? fresnel_dielectric(cosine, coat_.n) : 0; }

  double top(const Vec3& wi, const Vec3& wo) const {
    if (!(coat_.n > 1)) return 0;
    const Vec3 h = half_vector(wi, wo);
    const double half = (wi + wo).norm() / 2;  // cos(δ/2)
    const double facets = top_normals_.D(h) * fresnel_dielectric(half, coat_.n) / 4;
    if (form_ == SunForm::AsPrinted) return facets * h.z() / half;
    return facets * (top_normals_.G1(wi) / wi.z()) * (top_normals_.G1(wo) / wo.z());
  }

  std::optional<Vec3> from_below(const Vec3& wi, double lambda_um, const Vec2& xi) const {
    const auto drawn = substrate_.sample(detail::refracted(wi, coat_.n), lambda_um, xi);
    return drawn ? detail::leaving(drawn->wo, coat_.n) : std::nullopt;
  }

  Substrate substrate_;
  Coat coat_;
  SunForm form_;
  Beckmann top_normals_;
};

}  // namespace micro
