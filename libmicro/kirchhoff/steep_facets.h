#pragma once

#include <cstdint>
#include <vector>

#include "kirchhoff/gridding.h"
#include "kirchhoff/quadrature_lattice.h"

namespace micro {

/// What a facet's phase e^{−iq·s} turns with.
struct FacetPhases {
  double q = 0;             ///< |q|, rad/µm
  double sin_theta = 1;     ///< of the outermost direction
  double tolerance = 1e-5;  ///< of rules that integrate it (gauss_rule.h)
};

/// The facets that a lattice leaves out (QuadratureLattice), and how many points their quadrature takes.
struct SteepFacets {
  std::vector<Triangle> facets;           ///< by rows
  std::vector<std::int64_t> first_point;  ///< [facets + 1] of each, and their number
  std::int64_t points() const { return first_point.back(); }
};

SteepFacets find_steep_facets(const QuadratureLattice& lattice, const FacetPhases& phases);

/// Quadrature of these facets: Σ area·f(x, y, z) ≈ ∫f dxdy. A facet is cut along the level line through its
/// middle corner; each half is mapped to a square, (t, s) → A + t·((B − A) + s·(C − B)) with B and C at one
/// height [Duffy82], so that the height turns along t alone: as many Gauss–Legendre points along t as the
/// height's phase takes, a few along s. A cliff of ten micrometres costs some hundred points where equal
/// triangles would cost ten thousand.
std::vector<SurfacePoint> facet_points(const QuadratureLattice& lattice, const SteepFacets& steep,
                                       const FacetPhases& phases);

/// How many points a triangle of this slope takes, about.
double expected_facet_points(double slope, double pitch, const FacetPhases& phases);

}  // namespace micro
