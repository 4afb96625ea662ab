#pragma once

#include <complex>
#include <functional>
#include <span>
#include <vector>

#include "kirchhoff/coherence.h"
#include "kirchhoff/kirchhoff.h"

namespace micro {

/// F(q) of [Dong15 Eq. 6] (kirchhoff.h) in µm, in closed form for the triangulated surface, q in rad/µm (any
/// vector). The mean of e^{−iφ} over a triangle with corner phases φ₁, φ₂, φ₃ is twice the second divided
/// difference of the exponential; its error stays below 1e-12 of the envelope min(1, 1/spread) for every
/// spacing of the phases, since differences of phases come from differences of coordinates. Costs
/// O(triangles): four sines and cosines a vertex. Sums rows in a fixed order: any number of threads gives the
/// same bits. Zero for a surface without triangles.
std::complex<double> exact_field(const HeightField& surface, const Vec3& q);

/// The same for many wave vectors.
std::vector<std::complex<double>> exact_field(const HeightField& surface, std::span<const Vec3> q);

/// The same for a coherent window, Σ_T W_T (q·a_T) mean_T, W_T the taper of the triangle's cell; D is
/// |F|²/(4π² · effective_area(window)).
std::vector<std::complex<double>> exact_field(const Window& window, std::span<const Vec3> q);

/// The amplitude of Fresnel reflection as a function of the facet's unit normal m [Dong15 Eq. 3, R(s, wi,
/// wo)].
using FacetReflectance = std::function<std::complex<double>(const Vec3& m)>;

/// ∫_S R (q·m) e^{−iq·s} ds in µm [Dong15 Eq. 3], for a reflectance that varies over the surface. Also
/// O(triangles), and one call of `reflectance` for each, from several threads.
std::complex<double> exact_field(const HeightField& surface, const Vec3& q,
                                 const FacetReflectance& reflectance);

/// D_K(q) in 1/sr [Dong15 Eq. 6]. Throws InputError if not one triangle is there.
double exact_density(const HeightField& surface, const Vec3& q);

}  // namespace micro
