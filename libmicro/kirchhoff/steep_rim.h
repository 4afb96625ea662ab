#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kirchhoff/quadrature_lattice.h"
#include "kirchhoff/steep_facets.h"

namespace micro {

/// The edges of the rim that a lattice leaves out (QuadratureLattice), row by row.
struct SteepRim {
  std::vector<RimEdge> edges;
  std::int64_t points = 0;  ///< that rim_points() will make of them
};

SteepRim find_steep_rim(const QuadratureLattice& lattice, const FacetPhases& phases);

/// Quadrature of these edges by Gauss–Legendre rules: Σ weight·f(x, y, z) ≈ ∮ f n_x dl by the first points,
/// ∮ f n_y dl by the second.
std::array<std::vector<SurfacePoint>, 2> rim_points(const QuadratureLattice& lattice, const SteepRim& rim,
                                                    const FacetPhases& phases);

}  // namespace micro
