#pragma once

#include <algorithm>
#include <cstdint>

#include "distribution/disk_table.h"
#include "kirchhoff/height_basis.h"
#include "kirchhoff/spectral_work.h"
#include "kirchhoff/steep_facets.h"
#include "kirchhoff/term_tables.h"

namespace micro {

/// Grid rows transformed together, so that their spectra are written by cache lines.
inline constexpr std::int64_t kRowGroup = 8;

/// Numbers that all stages of disk_transform.h share. The origin of the grid is the surface's.
struct DiskGeometry {
  double sphere;                                ///< |q|², rad²/µm²
  double step;                                  ///< between nodes, rad/µm
  double pitch;                                 ///< of the grid, µm
  std::int64_t length;                          ///< of a transform: the grid's period
  int half;                                     ///< c: nodes −c … c
  std::int64_t x_begin, x_end, y_begin, y_end;  ///< grid points within reach of the sources
  std::int64_t rows() const { return std::min(length, y_end - y_begin); }  ///< after folding
  std::int64_t padded_rows() const { return (rows() + kRowGroup - 1) / kRowGroup * kRowGroup; }
  std::int64_t wrap(std::int64_t m) const { return ((m % length) + length) % length; }
};

DiskGeometry make_disk_geometry(const HeightField& surface, const DiskGrid& grid, double lambda_q,
                                const SpectralChoice& choice);

/// Of the nodes on a table, at |q| = `radius` rad/µm: their q_z, and what phases on a facet turn with, to be
/// integrated so well that an expansion of ψ to `basis_tolerance` does not feel it.
WaveRange wave_range(double radius, const DiskGrid& grid);
FacetPhases facet_phases(double radius, const DiskGrid& grid, double basis_tolerance);

/// k_x² + k_y² that occur among a table's nodes on the disk, at most.
double distances(const DiskGeometry& g);

/// Tables for nodes on the disk: c_k for equidistant q_z, or for each of the distances where they are fewer.
TermTables disk_tables(const DiskGeometry& g, double phase_reach, double tolerance);

/// Terms of one pass.
int disk_pass(const DiskGeometry& g, const TermTables& tables, Sums sums);

/// What a basis on a lattice and on its steep facets takes; I[1] counts as a term.
SpectralWork disk_work(const DiskGeometry& g, const HeightField& surface, const SpectralChoice& choice,
                       std::int64_t steep_points, const BasisSize& basis);

}  // namespace micro
