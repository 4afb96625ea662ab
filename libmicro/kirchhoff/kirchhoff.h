#pragma once

#include <complex>

#include "core/grid.h"
#include "height/height_field.h"

namespace micro {

/// The Kirchhoff distribution [Dong15 Eq. 6] of the triangulated surface S (height/triangles.h),
///   D_K(q) = |F(q)|² / (4π² A_perp),   F(q) = ∫_S (q·m) e^{−i q·s} ds = Σ_T (q·a_T) mean_T(e^{−i q·s}),
/// with q in rad/µm, s = (i·dx, j·dy, z(j, i)) in µm, m the facet normal, a_T the area vector of triangle T
/// (µm², a_z > 0) and A_perp = projected_area(surface). D_K is per steradian. The origin of s only turns the
/// phase of F: the height field's removed mean is left out of s_z.
///
/// Every estimator (exact, Monte Carlo, spectral) estimates this one number.

/// The wave vector q = (4π/λ_q) h in rad/µm of half direction h (a unit vector) at effective wavelength
/// λ_q = λ/cos(θ_d/2) in µm [Dong15 Eqs. 4, 5]. Throws InputError unless λ_q is positive and finite.
Vec3 wave_vector(const Vec3& h, double lambda_q);

/// D_K = |F|² / (4π² A_perp) in 1/sr, F in µm, A_perp in µm² [Dong15 Eq. 6].
double kirchhoff_density(std::complex<double> field, double projected_area);

/// A_perp of a surface that D_K can be asked of, µm². Throws InputError if not one triangle is there.
double kirchhoff_area(const HeightField& surface);

}  // namespace micro
