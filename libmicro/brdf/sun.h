#pragma once

#include <cmath>
#include <limits>

#include "brdf/free_travel.h"
#include "brdf/microfacet.h"
#include "distribution/beckmann.h"

namespace micro {

/// Whether a formula of [Sun02] or [SunGlossy] is taken as derived or as its paper prints it.
enum class SunForm { Corrected, AsPrinted };

/// The normals of an isotropic Gaussian surface of smoothness s = τ/σ_h, Beckmann's with α = 2/s [Sun02 Eq.
/// 3.3.9]. Throws InputError unless s is positive and finite.
Beckmann normals_of_smoothness(double s);

/// The same, masked by Sun's free travel probability Γ₀ in place of Smith's G1 [3.4.23]. It lies below G1 at
/// every angle.
class SunNormals : public Beckmann {
 public:
  explicit SunNormals(double s) : Beckmann(normals_of_smoothness(s)), s_(s) {}

  double s() const { return s_; }
  double G1(const Vec3& u) const {
    const double across = std::hypot(u.x(), u.y());
    return free_travel_probability(
        across > 0 ? s_ * u.z() / across : std::copysign(std::numeric_limits<double>::infinity(), u.z()));
  }

 private:
  double s_;
};

/// The one-term BRDF of a metallic rough surface [Sun02 Eq. 3.5.3]: one bounce, Fresnel times Γ₀Γ₀ times the
/// slopes' density p = s²/(4π)·exp(−s² tan²θ/4), θ the half vector's polar angle, δ the angle between wi and
/// wo.
///   Corrected: F·Γ₀Γ₀·p/(4 cos⁴θ cosθ_i cosθ_o), the microfacet form
///   AsPrinted: F·Γ₀Γ₀·p/(4 cos³θ cos(δ/2)): a facet's area and the light it takes are counted per facet, not
///              per plane. In the mirror's direction it is cosθ_i times the corrected form.
class SunReflection {
 public:
  explicit SunReflection(double s, Fresnel fresnel = Fresnel(), SunForm form = SunForm::Corrected)
      : facets_(SunNormals(s), std::move(fresnel)), form_(form) {}

  double s() const { return facets_.normals().s(); }
  SunForm form() const { return form_; }
  const Fresnel& fresnel() const { return facets_.fresnel(); }

  double f(const Vec3& wi, const Vec3& wo, double lambda_um) const {
    return facets_.f(wi, wo, lambda_um) * form_factor(wi, wo);
  }
  /// Draws the corrected form's visible normals.
  std::optional<BrdfSample> sample(const Vec3& wi, double lambda_um, const Vec2& xi) const {
    std::optional<BrdfSample> drawn = facets_.sample(wi, lambda_um, xi);
    if (drawn) drawn->f *= form_factor(wi, drawn->wo);
    return drawn;
  }
  double pdf(const Vec3& wi, const Vec3& wo, double lambda_um) const {
    return facets_.pdf(wi, wo, lambda_um);
  }

 private:
  /// The form over the corrected one: cosθ cosθ_i cosθ_o/cos(δ/2), 2cos(δ/2) = |wi + wo|.
  double form_factor(const Vec3& wi, const Vec3& wo) const {
    if (form_ == SunForm::Corrected) return 1;
    const Vec3 sum = wi + wo;
    const double length2 = sum.squaredNorm();
    return length2 > 0 ? 2 * sum.z() * (wi.z() * wo.z()) / length2 : 0;
  }

  Microfacet<SunNormals> facets_;
  SunForm form_;
};
static_assert(Brdf<SunReflection>);

}  // namespace micro
