#pragma once

#include "height/height_field.h"

namespace micro {

constexpr int kMostSubdivision = 32;

/// What the spectral estimator's quadrature (quadrature_lattice.h) is judged by.
struct SubdivisionDemands {
  double phase = 0;      ///< |q|·pitch, rad
  double sin_theta = 1;  ///< of the outermost direction
  double tolerance = 1e-3;
};

/// How finely the triangles have to be cut, judged from the relief before anything is computed. Three laws,
/// their constants measured against `exact`:
/// - Facets whose phase turns by more than a whole period of the lattice in some direction on the table,
///   |q|·(sinθ + slope·cosθ)·d > 2π·n, are taken for gentler ones (they alias), so hardly any such facet may
///   be left.
/// - On a plane the lattice's sum is the integral. Where the slope changes by κ from facet to facet, the
///   midpoint rule errs by the jump of the third derivative of e^{−iq·s} [Euler–Maclaurin], ∝
///   sin²θ·κ·(|q|d/n)³ a cell; cells add up at random, and the lobe's peak is as low as the typical sinθ is
///   large: a relative error of 4e-3·(|q|d/n)⁴·sinθ·√⟨sin⁴θ·κ²⟩ in all, where a phase beyond the lattice's
///   half period counts as that. It holds within a factor of four from polished to milled metal.
/// - Along rims the in-plane phase alone counts: in the whole where rims are dense, and always in the
///   directions far from the peak, which have 30 times the tolerance.
int choose_subdivision(const HeightField& surface, const SubdivisionDemands& demands);

}  // namespace micro
