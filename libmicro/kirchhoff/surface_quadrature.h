#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "kirchhoff/quadrature_lattice.h"
#include "kirchhoff/steep_facets.h"

namespace micro {

/// All of a surface: the lattice, and the points of the facets that it leaves out.
struct SurfaceQuadrature {
  SurfaceQuadrature(QuadratureLattice all, const SteepFacets& left_out, const FacetPhases& phases)
      : lattice(std::move(all)), steep(facet_points(lattice, left_out, phases)) {}
  QuadratureLattice lattice;
  std::vector<SurfacePoint> steep;
  std::int64_t bytes() const { return static_cast<std::int64_t>(steep.size() * sizeof(SurfacePoint)); }
};

}  // namespace micro
