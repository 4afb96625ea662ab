#pragma once

#include <optional>

#include "distribution/disk_table.h"
#include "distribution/signature_kernel.h"

namespace micro {

/// Distance (radians) between the points of a polar grid (θ, φ) from which cubic-like interpolation (six
/// points) recovers the signature's profile to 2e-5 of its peak; nothing if that needs more than 200 points
/// from its centre to its end.
std::optional<double> ring_spacing(const Signature& signature);

/// How `convolve` spreads a table's mass, for smooth signatures that are wide beside the table's spacing:
/// K(m, h) ≈ Σ_ab L_a(m) K(a, b) L_b(h), a and b on rings θ = const `spacing` apart and L the interpolation
/// of six points in θ and six in φ. Rings are turned copies of themselves, so each pair of rings takes one
/// Fourier multiplication. The shares are normalised with the same K, hence mass is kept exactly; ripples
/// below zero (interpolation at the signature's cut) are cut off and made up for by a common factor.
DiskTable convolve_on_rings(const DiskTable& table, const SignatureKernel& kernel, double spacing);

/// Elementary operations of that, about a nanosecond each.
double cost_on_rings(const DiskTable& table, const SignatureKernel& kernel, double spacing);

}  // namespace micro
