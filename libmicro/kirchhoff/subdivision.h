#pragma once

#include "height/height_field.h"

namespace micro {

constexpr int kMostSubdivision = 32;

/// What the spectral estimator's quadrature is judged by.
struct SubdivisionDemands {
  double phase = 0;      ///< |q|·pitch, rad
  double sin_theta = 1;  ///< of the outermost direction
  double tolerance = 1e-3;
  int kernel_width = 5;  ///< of gridding: what spreading one point costs
};

struct Subdivision {
  int n = 1;            ///< of the lattice (quadrature_lattice.h)
  double steepest = 0;  ///< facets of a greater slope are integrated one by one (steep_facets.h)
};

/// How finely the triangles have to be cut, judged from the relief before anything is computed. Three laws,
/// their constants measured against `exact`:
/// - Facets whose phase turns by a whole period of the lattice in some direction on the table,
///   |q|·(sinθ + slope·cosθ)·d = 2π·n, are taken for level ones (they alias): those beyond 0.7 of it are
///   integrated one by one. Three quarters of all stay within a quarter of it, because on a periodic surface
///   errors add up coherently.
/// - On a plane the lattice's sum is the integral. Where the slope changes by κ from facet to facet, the
///   midpoint rule errs by the jump of the third derivative of e^{−iq·s} [Euler–Maclaurin], ∝
///   sin²θ·κ·(|q|d/n)³ a cell; cells add up at random, and the lobe's peak is as low as the typical sinθ is
///   large: a relative error of 4e-3·(|q|d/n)⁴·sinθ·√⟨sin⁴θ·κ²⟩ in all, where a phase beyond the lattice's
///   half period counts as that. It holds within a factor of four from polished to milled metal.
/// - Along rims the in-plane phase alone counts: in the whole where rims are dense, and always in the
///   directions far from the peak, which have 30 times the tolerance.
///
/// Of all that keep the tolerance, the pair that costs the fewest multiply-adds: a few cliffs are left out of
/// a coarse lattice, where all is steep the lattice is fine.
Subdivision choose_subdivision(const HeightField& surface, const SubdivisionDemands& demands);

}  // namespace micro
