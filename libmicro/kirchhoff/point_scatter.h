#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kirchhoff/gridding.h"
#include "kirchhoff/quadrature_lattice.h"

namespace micro {

/// Points anywhere on the surface, with the grid points within the kernel's reach of each; in ascending order
/// of the first grid row.
template <typename Real>
struct PointScatter {
  int taps = 0;
  std::vector<std::int32_t> col, row;  ///< [points] the first grid column and row, from the grid's first
  std::vector<Real> x, y;              ///< [points, taps] K along either axis
  std::vector<float> z;                ///< [points] µm
  std::vector<float> area;             ///< [points] µm²
  std::size_t size() const { return z.size(); }
  std::int64_t bytes() const {
    return static_cast<std::int64_t>(size() *
                                     (2 * (sizeof(std::int32_t) + sizeof(float)) + 2 * taps * sizeof(Real)));
  }
};

/// One axis of the grid that points are spread onto.
struct ScatterAxis {
  const GriddingKernel& kernel;
  std::int64_t begin, end;              ///< grid points, at multiples of the kernel's pitch
  std::span<const double> factor = {};  ///< [end − begin] on what reaches each grid point; empty: 1
};

/// Spreads the points by kernels of one width in grid points.
template <typename Real>
PointScatter<Real> make_point_scatter(std::span<const SurfacePoint> points, const ScatterAxis& x,
                                      const ScatterAxis& y);

}  // namespace micro
