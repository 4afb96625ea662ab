#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "kirchhoff/quadrature_lattice.h"
#include "kirchhoff/steep_facets.h"
#include "kirchhoff/steep_rim.h"

namespace micro {

/// What a lattice leaves out, and how many points it takes instead.
struct LeftOut {
  LeftOut(const QuadratureLattice& lattice, const FacetPhases& turning)
      : phases(turning), facets(find_steep_facets(lattice, phases)), rim(find_steep_rim(lattice, phases)) {}
  FacetPhases phases;
  SteepFacets facets;
  SteepRim rim;
  std::int64_t points() const { return facets.points() + rim.points; }
};

/// All of a surface: the lattice, and the points of the facets and of the rim that it leaves out.
struct SurfaceQuadrature {
  SurfaceQuadrature(QuadratureLattice all, const LeftOut& left_out)
      : lattice(std::move(all)),
        steep(facet_points(lattice, left_out.facets, left_out.phases)),
        steep_rim(rim_points(lattice, left_out.rim, left_out.phases)) {}
  QuadratureLattice lattice;
  std::vector<SurfacePoint> steep;
  std::array<std::vector<SurfacePoint>, 2> steep_rim;  ///< of ∮ n_x dl and of ∮ n_y dl
  std::int64_t bytes() const {
    return static_cast<std::int64_t>((steep.size() + steep_rim[0].size() + steep_rim[1].size()) *
                                     sizeof(SurfacePoint));
  }
};

}  // namespace micro
