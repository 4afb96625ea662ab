#pragma once

#include "distribution/distribution.h"
#include "distribution/slope_lobe.h"

namespace micro {

/// Gaussian slopes v with density e^{−|v|²}/π, Beckmann's α = 1: each has variance ½.
struct GaussianShape {
  static double density(double vv, double z);
  static double visible_area(const Vec3& u);
  static Vec2 sample(const Vec2& xi);
  static Vec2 sample_visible(const Vec3& u, const Vec2& xi);
};

/// The anisotropic Beckmann distribution, its slopes Gaussian with mean t and covariance Σ/2. It takes the
/// same place in slope space as the ellipsoid, and so the same five parameters.
using Beckmann = SlopeLobe<GaussianShape>;
static_assert(Distribution<Beckmann>);

/// A surface whose heights are Gaussian with correlation σ_h²·exp(−x²/τ_x² − y²/τ_y²), all in µm, seen
/// through plane fits under a Gaussian window of standard deviation `filter` [Dong15 §5.1]; 0: the surface
/// itself.
struct GaussianSurfaceStatistics {
  double sigma_h, tau_x, tau_y;
  double filter = 0;
};

/// Its normals: Beckmann with α_x² = 4σ'²/τ'_x², τ'² = τ² + 4·filter², σ'² = σ_h²τ_xτ_y/(τ'_xτ'_y). Throws
/// InputError unless heights and lengths are positive.
Beckmann gaussian_surface_normals(const GaussianSurfaceStatistics& surface);

}  // namespace micro
