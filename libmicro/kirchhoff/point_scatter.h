#pragma once

#include <array>
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
  std::vector<Real> x, y;              ///< [points, taps] K, or its slope, along either axis
  std::vector<double> z;               ///< [points] µm
  std::vector<float> weight;           ///< [points] of SurfacePoint
  std::size_t size() const { return z.size(); }
  std::int64_t bytes() const {
    return static_cast<std::int64_t>(
        size() * (2 * sizeof(std::int32_t) + sizeof(double) + sizeof(float) + 2 * taps * sizeof(Real)));
  }
};

/// What points are spread by along an axis.
enum class SpreadBy { Kernel, Slope };

/// One axis of the grid that points are spread onto.
struct ScatterAxis {
  const GriddingKernel& kernel;
  std::int64_t begin, end;              ///< grid points, at multiples of the kernel's pitch
  std::span<const double> factor = {};  ///< [end − begin] on what reaches each grid point; empty: 1
  SpreadBy by = SpreadBy::Kernel;       ///< K, or dK/dx at (grid point − source)
};

/// Spreads the points by kernels of one width in grid points.
template <typename Real>
PointScatter<Real> make_point_scatter(std::span<const SurfacePoint> points, const ScatterAxis& x,
                                      const ScatterAxis& y);

/// Points of ∮ n_x dl and of ∮ n_y dl (steep_rim.h), spread by the kernel's slope along x and along y.
template <typename Real>
std::array<PointScatter<Real>, 2> make_rim_scatter(const std::array<std::vector<SurfacePoint>, 2>& points,
                                                   const ScatterAxis& x, const ScatterAxis& y) {
  ScatterAxis slope_x = x, slope_y = y;
  slope_x.by = slope_y.by = SpreadBy::Slope;
  return {make_point_scatter<Real>(points[0], slope_x, y), make_point_scatter<Real>(points[1], x, slope_y)};
}

}  // namespace micro
