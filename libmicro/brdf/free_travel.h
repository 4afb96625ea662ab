#pragma once

#include "core/estimate.h"

namespace micro {

/// Free travel probability of [Sun02 §3.4]: the part of the rays that leave a Gaussian surface of heights σ_h
/// and correlation C = exp(−r²/τ²) at polar angle θ and never meet it. Stretching the heights, or the plane,
/// stretches the rays alike, so it depends on
///   ν = s·cot θ,  s = τ/σ_h,
/// alone (his scaling invariance), besides the height η = h/σ_h where the ray starts. ν = ∞ is the normal, ν
/// = 0 the horizon.
///
/// His model: a ray at distance x = τt is lost at the rate k·Q, k = 1/τ, where Q = P(surface above the ray |
/// the height it left) [3.4.1, 3.4.7]. Hence
///   Γ(η) = exp(−∫₀^∞ Q dt),  Q = ½ erfc(w/√2),
///   w = (η(1 − C) + νt)/√(1 − C²) = η√tanh(t²/2) + νt/√(1 − e^{−2t²})  [3.4.8]:
/// the integral is the mean length of the surface above the ray, in τ. The rays that start into the surface,
/// on a facet that faces away, are among those lost.

/// Γ₀ = exp(−e^{−ν²/4}/(√(2π)ν)) [3.4.23]: η = 0 with w = νt, which is true far away only. Goes from 0 at ν ≤
/// 0 to 1.
double free_travel_probability(double nu);

/// ∫₀^∞ Q dt [3.4.10] for any η and ν > 0, to the relative tolerance `tol`; the error is the last change of
/// the trapezoidal rule, which refined once more is far smaller. ν = ∞ gives 0.
Estimate<double> mean_covered_length(double eta, double nu, double tol);

/// Γ(η) = exp(−∫Q dt) [3.4.14] to the absolute tolerance `tol`, ν > 0.
Estimate<double> free_travel_probability(double eta, double nu, double tol);

/// ⟨Γ(η, ν₁)Γ(η, ν₂)⟩ over the normal distribution of heights [3.2.11, 3.5.1], to the absolute tolerance
/// `tol`; ν > 0. One factor alone is ⟨Γ(η, ν)⟩ with the other ν = ∞.
Estimate<double> mean_free_travel_product(double nu1, double nu2, double tol);

}  // namespace micro
