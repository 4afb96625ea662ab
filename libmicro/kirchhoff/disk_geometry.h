#pragma once

#include <algorithm>
#include <cstdint>

#include "distribution/disk_table.h"
#include "kirchhoff/height_basis.h"
#include "kirchhoff/spectral_work.h"
#include "kirchhoff/steep_facets.h"

namespace micro {

/// Numbers that all stages of disk_transform.h share. The origin of the grid is the surface's.
struct DiskGeometry {
  double sphere;                                ///< |q|², rad²/µm²
  double step;                                  ///< between nodes, rad/µm
  double pitch;                                 ///< of the grid, µm
  std::int64_t length;                          ///< of a transform: the grid's period
  int half;                                     ///< c: nodes −c … c
  std::int64_t x_begin, x_end, y_begin, y_end;  ///< grid points within reach of the sources
  std::int64_t rows() const { return std::min(length, y_end - y_begin); }  ///< after folding
  std::int64_t wrap(std::int64_t m) const { return ((m % length) + length) % length; }
};

DiskGeometry make_disk_geometry(const HeightField& surface, const DiskGrid& grid, double lambda_q,
                                const SpectralChoice& choice);

/// Of the nodes on a table, at |q| = `radius` rad/µm: their q_z, and what phases on a facet turn with, to be
/// integrated so well that an expansion of ψ to `basis_tolerance` does not feel it.
WaveRange wave_range(double radius, const DiskGrid& grid);
FacetPhases facet_phases(double radius, const DiskGrid& grid, double basis_tolerance);

/// What so many terms of a lattice and of its steep facets take.
SpectralWork disk_work(const DiskGeometry& g, const HeightField& surface, const SpectralChoice& choice,
                       std::int64_t steep_points, int terms);

}  // namespace micro
