#pragma once

#include <limits>

#include "distribution/disk_table.h"
#include "kirchhoff/coherence.h"
#include "kirchhoff/combine.h"
#include "kirchhoff/height_basis.h"
#include "kirchhoff/quadrature_lattice.h"
#include "kirchhoff/steep_facets.h"

namespace micro {

/// How finely a table is computed. Every one of them only trades time for error.
struct SpectralChoice {
  double basis_tolerance = 1e-3;  ///< of ψ's expansion, relative: see height_basis.h
  int subdivision = 1;            ///< of the triangles (quadrature_lattice.h) …
  /// … but for those of a greater slope (steep_facets.h).
  double steepest = std::numeric_limits<double>::infinity();
  int kernel_width = 6;        ///< of gridding, in grid points
  double oversampling = 1.25;  ///< of the transform over the table, at least
  bool operator==(const SpectralChoice&) const = default;
};

/// What it took.
struct SpectralWork {
  int terms = 0;  ///< real images
  std::int64_t fft_length = 0;
  std::int64_t transforms = 0;    ///< complex transforms of fft_length numbers, rows and columns
  std::int64_t bytes = 0;         ///< of memory held at most, without the table
  double spread = 0;              ///< multiply-adds that take the sources to the grid, about
  std::int64_t steep_points = 0;  ///< on facets that the lattice leaves out
};

/// Memory that may serve one table after the other; nothing in it outlives a call.
template <typename Real>
struct DiskMemory {
  FftVector<std::complex<Real>> spectra;
  DiskField<Real> field;
};

struct DiskDensity {
  DiskTable table;
  SpectralWork work;
};

/// D_K on every node of the table in one go, at one |q| = 4π/λ_q. In letters, with ψ = (e^{−iq_z h} − 1)/q_z,
///   F(q) = q_z·I[1] + |q|²·I[ψ] − i ∮ (q_⊥·n) ψ e^{−iq_⊥·x} dl,   I[f] = ∫ f(x) e^{−iq_⊥·x} dxdy,
/// which follows from Eq. 6 by parts on the piecewise linear surface and has nothing to divide by q_z. Since
/// |q| is the same at all nodes, the last two terms are the spectrum of one image, and with ψ ≈ Σ c_k(q_z)
/// φ_k(h) that of a few real images, two to a complex transform: sources at quadrature points, dipoles on the
/// rim and around holes, spread onto a grid whose transform lands on the nodes. Sources beyond the grid's
/// period fold into it, which is exact.
///
/// A taper weighs the cells, and the edges between cells of different weight are rims of that difference.
///
/// `Real` is float (error about 1e-6 of the peak of |F| without the coherent part) or double.
/// Throws InputError if not one triangle is there, or if the lattice has so many points that a table would
/// take hours.
template <typename Real>
DiskDensity transform_disk(const Window& window, const DiskGrid& grid, double lambda_q,
                           const SpectralChoice& choice, DiskMemory<Real>& memory);

/// Throws InputError if transforming so many terms of so fine a lattice would take hours; says how far out
/// the table may go instead.
void check_work(const SurfaceQuadrature& quadrature, int terms, double lambda_q);

/// What a table will take, without computing it; `bytes` is left out, and `terms` is what the ranges of
/// heights and of q_z suggest (expected_terms).
SpectralWork predict_work(const Window& window, const DiskGrid& grid, double lambda_q,
                          const SpectralChoice& choice);

}  // namespace micro
