#pragma once

#include "core/grid.h"
#include "testing/gaussian_surface.h"

namespace micro::testing {

/// Means of D_K over ensembles of smooth Gaussian surfaces, from their statistics alone.

/// The incoherent part of ⟨D_K⟩ per steradian of a patch much larger than τ:
///   |q|⁴ τ_x τ_y/(4π q_z²) Σ_{m≥1} g^m e^{−g}/(m!·m) · exp(−(q_x²τ_x² + q_y²τ_y²)/4m),   g = q_z²σ²,
/// from ⟨|∫e^{−iq·s}dxdy|²⟩ = A∫e^{−iq_⊥·Δ}(e^{−g(1−C(Δ))} − e^{−g})dΔ, C^m = exp(−m(x²/τ_x² + y²/τ_y²)) and
/// (q·m)ds → |q|²/q_z dxdy (by parts, boundary left out). Terms are summed as logarithms around the largest:
/// g from 1e-6 to 1e6 and exponents down to −700 keep 1e-10. q_z ≠ 0.
double gaussian_mean_density(const Vec3& q, const GaussianStatistics& statistics);

/// The coherent part for a patch of lengths L_x, L_y: ⟨(q_z − q_⊥·∇z)e^{−iq_z z}⟩ = q_z e^{−g/2}, slope and
/// height of one point being independent, so |⟨F⟩|²/(4π²A) = q_z² A e^{−g} sinc²(q_xL_x/2)
/// sinc²(q_yL_y/2)/4π².
double gaussian_coherent_density(const Vec3& q, const GaussianStatistics& statistics, double length_x,
                                 double length_y);

/// ⟨D_K⟩ of a rectangular patch, coherent part, boundary and slopes included, for any q: the integral over
/// separations Δ of (1 − |Δ_x|/L_x)(1 − |Δ_y|/L_y) e^{−iq_⊥·Δ} e^{−g(1−C)} [q_z²(1 + ic)² − σ²(q_⊥·∇)²C]/4π²,
/// c = −σ² q_⊥·∇C, which is E[(q_z − q_⊥·∇z₁)(q_z − q_⊥·∇z₂) e^{−iq_z(z₁−z₂)}] for jointly normal heights and
/// slopes. Gauss–Legendre panels; costs (L·(|q_⊥| + √(1+g)/τ))² evaluations.
double gaussian_patch_density(const Vec3& q, const GaussianStatistics& statistics, double length_x,
                              double length_y);

/// ⟨D_K⟩ under a Gaussian taper exp(−r²/2s²), of infinite extent: the series with the taper's autocorrelation
/// exp(−Δ²/4s²) under the integral, so that m/τ² becomes m/τ² + 1/4s² and m = 0 is the coherent part:
/// every feature is blurred by exp(−s²q_⊥²), i.e. by λ_q/(4π√2 s) (standard deviation in each of h_x, h_y).
double gaussian_tapered_density(const Vec3& q, const GaussianStatistics& statistics, double s);

/// Beckmann's distribution exp(−m_x²/α_x²m_z² − m_y²/α_y²m_z²)/(π α_x α_y m_z⁴) per steradian.
double beckmann_density(const Vec3& m, double alpha_x, double alpha_y);

/// α = 2σ/τ: the slopes of the surface itself, and the limit of ⟨D_K⟩ for g → ∞.
Vec2 slope_alpha(const GaussianStatistics& statistics);

/// α of the slopes after Gaussian smoothing with standard deviation s: correlations widen to τ² + 4s² on each
/// axis and the variance falls by τ_xτ_y/√((τ_x²+4s²)(τ_y²+4s²)); isotropic: α² = 4σ²τ²/(τ²+4s²)².
Vec2 filtered_slope_alpha(const GaussianStatistics& statistics, double s);

}  // namespace micro::testing
