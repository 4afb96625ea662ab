#pragma once

#include <complex>
#include <span>

#include "core/grid.h"

namespace micro::testing {

/// F(q) of kirchhoff.h, in µm, for surfaces over the rectangle [0, L_x] × [0, L_y] that have a closed form.
struct Rectangle {
  double length_x, length_y;  ///< µm
};

/// The plane z = s_x x + s_y y: two sincs.
std::complex<double> plate_field(const Rectangle& patch, const Vec2& slope, const Vec3& q);

/// The grating z = a cos(Kx + φ₀): orders n with amplitudes (−i)ⁿ J_n(q_z a) at q_x = nK, each a sinc as wide
/// as the patch, and the factor q·m by parts: |q_⊥x|² + q_z² over q_z, less its boundary term. q_z ≠ 0.
std::complex<double> sinusoid_field(const Rectangle& patch, double amplitude, double wave_number,
                                    double phase, const Vec3& q);

/// A profile z(x), piecewise linear between equidistant nodes from 0 to L_x and constant along y, such as a
/// two-level grating: one sinc per piece. Exact for the triangulated surface too, which is ruled along y.
std::complex<double> profile_field(const Rectangle& patch, std::span<const double> heights, const Vec3& q);

}  // namespace micro::testing
