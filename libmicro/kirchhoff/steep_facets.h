#pragma once

#include <vector>

#include "kirchhoff/gridding.h"
#include "kirchhoff/quadrature_lattice.h"

namespace micro {

/// What a facet's phase e^{−iq·s} turns with.
struct FacetPhases {
  double q = 0;          ///< |q|, rad/µm
  double sin_theta = 1;  ///< of the outermost direction
};

/// So many points of a Gauss–Legendre rule integrate e^{iφt}, 0 ≤ t ≤ 1, to some 1e-5.
int gauss_points(double phase);

/// Quadrature of the facets that a lattice leaves out (QuadratureLattice): Σ area·f(x, y, z) ≈ ∫f dxdy. A
/// facet is cut along the level line through its middle corner; each half is mapped to a square, (t, s) →
/// A + t·((B − A) + s·(C − B)) with B and C at one height [Duffy82], so that the height turns along t alone:
/// as many Gauss–Legendre points along t as the height's phase takes, a few along s. A cliff of ten
/// micrometres costs some hundred points where equal triangles would cost ten thousand.
std::vector<SurfacePoint> steep_facet_points(const QuadratureLattice& lattice, const FacetPhases& phases);

/// All of a surface: the lattice, and the points of the facets that it leaves out.
struct SurfaceQuadrature {
  SurfaceQuadrature(const QuadratureLattice& all, const FacetPhases& phases)
      : lattice(all), steep(steep_facet_points(lattice, phases)) {}
  QuadratureLattice lattice;
  std::vector<SurfacePoint> steep;
};

/// How many they are, about, without making them.
std::int64_t count_facet_points(const QuadratureLattice& lattice, const FacetPhases& phases);

/// How many points steep_facet_points() gives for a triangle of these slopes, about.
double expected_facet_points(double slope, double pitch, const FacetPhases& phases);

}  // namespace micro
