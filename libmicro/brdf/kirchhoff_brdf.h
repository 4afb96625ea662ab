#pragma once

#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "brdf/microfacet.h"
#include "core/estimate.h"
#include "distribution/density_volume.h"
#include "distribution/table_integral.h"
#include "distribution/tabulated.h"

namespace micro {

/// λ_q of light of wavelength λ that turns by the full angle θ_d between wi and wo: λ/cos(θ_d/2) [Dong15 Eq.
/// 7].
inline double wavelength_q(double lambda_um, const Vec3& wi, const Vec3& wo) {
  return 2 * lambda_um / (wi + wo).norm();
}

/// q = (2π/λ)(wi + wo), rad/µm: along the half vector, of length 4π/λ_q [Dong15 Eqs. 6–8].
inline Vec3 momentum(double lambda_um, const Vec3& wi, const Vec3& wo) {
  return 2 * std::numbers::pi / lambda_um * (wi + wo);
}

/// D_K(q), 1/sr, q in rad/µm.
template <typename T>
concept WaveDensity = requires(const T& density, const Vec3& q) {
  { density(q) } -> std::convertible_to<double>;
};

/// The 3-D D_K of a volume, 0 beyond it (copies share it).
class VolumeDensity {
 public:
  explicit VolumeDensity(std::shared_ptr<const DensityVolume> volume) : volume_(std::move(volume)) {}

  /// What interpolation makes negative, where D all but vanishes, is 0.
  double operator()(const Vec3& q) const {
    if (!(q.cwiseAbs().head<2>().maxCoeff() <= volume_->extent().q_xy && q.z() <= volume_->extent().q_z))
      return 0;
    return std::max(0., (*volume_)(q));
  }

 private:
  std::shared_ptr<const DensityVolume> volume_;
};

/// D_K from tables at several λ_q, linear in |q| between them; beyond the first and last as those are. In a
/// medium of index n the light that is λ long in vacuum is λ/n long: q there is n times what is given.
class SpectrumDensity {
 public:
  /// λ_q in µm, ascending, a table for each. Throws InputError.
  SpectrumDensity(std::vector<double> lambda_q_um, const std::vector<Tabulated>& tables, double medium = 1);

  double operator()(const Vec3& q) const;

  /// ∫ D(q(h)) g(h) h_z dω over the half vectors h of what comes from wi, q = (4π/λ)(wi·h)h, to the absolute
  /// tolerance: exact in the tables' speckle, see TableIntegral.
  Estimate<double> over_half_vectors(const Vec3& wi, double lambda_um,
                                     const std::function<double(const Vec3& h)>& g, double tolerance) const;

 private:
  /// The table at or below a λ_q, and the share of the next one.
  struct Place {
    std::size_t table;
    double next;
  };
  Place place_of(double lambda_q_um) const;

  std::vector<double> lambda_q_;
  std::vector<Tabulated> tables_;
  std::vector<TableIntegral> integrals_;
  double medium_;
};

/// How much of each microfacet is taken as masked and shadowed: Smith's of the given normals, or nothing.
enum class Masking { Smith, None };

/// The wave-optics model [Dong15 Eqs. 7, 8]: f = D_K(4πh/λ_q) F(wi·h) G/(4 |wi·n| |wo·n|), λ_q =
/// λ/cos(θ_d/2). D_K does not know the light that misses the surface at grazing angles: without G the model
/// makes energy there (docs/brdf.md). `normals` give G1 and the directions that are drawn, a tenth of them
/// cosine distributed instead so that none is missed.
template <WaveDensity Density, Distribution Normals>
class KirchhoffBrdf {
 public:
  KirchhoffBrdf(Density density, const Normals& normals, Masking masking, Fresnel fresnel = Fresnel())
      : KirchhoffBrdf(std::move(density), normals, normals, masking, std::move(fresnel)) {}
  /// Directions drawn by other normals than those that mask: D_K's own at some λ_q, which weigh it evenly.
  KirchhoffBrdf(Density density, Normals masking_normals, Normals drawn, Masking masking,
                Fresnel fresnel = Fresnel())
      : density_(std::move(density)),
        normals_(std::move(masking_normals)),
        lobe_(std::move(drawn)),
        masking_(masking),
        fresnel_(std::move(fresnel)) {}

  double f(const Vec3& wi, const Vec3& wo, double lambda_um) const {
    if (!(wi.z() > 0 && wo.z() > 0)) return 0;
    const double cosine = (wi + wo).norm() / 2;
    return density_(momentum(lambda_um, wi, wo)) * (seen(wi) * seen(wo)) * fresnel_(cosine, lambda_um) / 4;
  }

  std::optional<BrdfSample> sample(const Vec3& wi, double lambda_um, const Vec2& xi) const {
    if (!(wi.z() > 0)) return std::nullopt;
    Vec3 wo;
    if (xi.x() < kCosineShare) {
      const double r = std::sqrt(xi.x() / kCosineShare), phi = 2 * std::numbers::pi * xi.y();
      wo = {r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - r * r)};
    } else {
      const auto drawn = lobe_.sample(wi, lambda_um, {(xi.x() - kCosineShare) / (1 - kCosineShare), xi.y()});
      if (!drawn) return std::nullopt;
      wo = drawn->wo;
    }
    const double density = pdf(wi, wo, lambda_um);
    if (!(density > 0)) return std::nullopt;
    return BrdfSample{wo, f(wi, wo, lambda_um), density};
  }

  double pdf(const Vec3& wi, const Vec3& wo, double lambda_um) const {
    if (!(wi.z() > 0 && wo.z() > 0)) return 0;
    return kCosineShare * wo.z() * std::numbers::inv_pi + (1 - kCosineShare) * lobe_.pdf(wi, wo, lambda_um);
  }

  /// ∫ f cosθ_o dω_o, dω_o being 4(wi·h)dω_h, over the tables where there are any: draws have to meet their
  /// speckle one by one.
  Estimate<double> albedo(const Vec3& wi, double lambda_um, double tolerance) const requires
      requires(const Density& d, const std::function<double(const Vec3&)>& g) {
    d.over_half_vectors(wi, lambda_um, g, tolerance);
  }
  {
    if (!(wi.z() > 0)) return {0, 0, {}};
    const double seen_from_light = seen(wi);
    const auto g = [&](const Vec3& h) {
      const double cosine = wi.dot(h);
      const Vec3 wo = mirrored(wi, h);
      if (!(cosine > 0 && wo.z() > 0)) return 0.;
      return seen_from_light * seen(wo) * wo.z() * fresnel_(cosine, lambda_um) * cosine / h.z();
    };
    return density_.over_half_vectors(wi, lambda_um, g, tolerance);
  }

 private:
  static constexpr double kCosineShare = 0.1;

  /// G1/cosθ, or 1/cosθ.
  double seen(const Vec3& u) const { return (masking_ == Masking::Smith ? normals_.G1(u) : 1) / u.z(); }

  Density density_;
  Normals normals_;
  Microfacet<Normals> lobe_;
  Masking masking_;
  Fresnel fresnel_;
};

/// Eq. 9 of [Dong15], the distribution that a reflectance f (1/sr) shows at the half vector where masking
/// does not matter: D ≈ 4 |wi·n| |wo·n| f/F. With masking it is D·G.
inline double density_from_reflectance(double f, double fresnel, const Vec3& wi, const Vec3& wo) {
  return 4 * wi.z() * wo.z() * f / fresnel;
}

}  // namespace micro
