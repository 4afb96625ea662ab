#pragma once

#include <array>
#include <cstdint>

#include "core/fft.h"
#include "kirchhoff/gridding.h"
#include "kirchhoff/point_scatter.h"
#include "kirchhoff/quadrature_lattice.h"

namespace micro {

/// Vectors of this many numbers hold the terms; term counts are padded to multiples of it.
constexpr int kTermLanes = 8;

/// φ_k on equidistant heights, for cubic Hermite interpolation: [entries, 2, padded] values and slopes.
template <typename Real>
struct FunctionTable {
  double low = 0;         ///< µm, height of entry 0
  double per_height = 0;  ///< entries per µm
  int entries = 0;        ///< ≥ 2
  int padded = 0;         ///< terms, a multiple of kTermLanes
  FftVector<Real> data;
  FftVector<Real>
      on_rim;  ///< [padded] factor on φ_k in integrals along the rim: 1, or 0 for a term that has none
};

/// Which part of the sources is spread: both, or one alone.
enum class SpreadSources { AreaAndRim, Area, Rim };

/// What is spread onto the grid that the Fourier transforms read, for every term k at once:
///   g_k(x) = Q² Σ_v area_v φ_k(h_v) K(x − v) − Σ_v φ_k(h_v) (n_v·∇K)(x − v),
/// v over the lattice and over the points of the facets and of the rim that it leaves out, so that its
/// spectrum is Q² Î[φ_k] − i ∮ (q_⊥·n) φ_k e^{−iq_⊥·x} dl, times the kernel's own: area and rim together.
template <typename Real>
struct SpreadProblem {
  const QuadratureLattice* lattice;
  const FunctionTable<Real>* functions;
  double q_squared;
  std::int64_t grid_cols;  ///< of the grid's rows, before they are folded into a period
  std::int64_t row_begin;  ///< grid row of the first entry of gather_y
  GatherTable<Real> gather_x, gather_x_odd, gather_y;
  ScatterTable<Real> scatter_x;
  PointScatter<Real> steep;                     ///< of steep_facets.h
  std::array<PointScatter<Real>, 2> steep_rim;  ///< of steep_rim.h, by the kernel's slope along x, along y
  SpreadSources sources = SpreadSources::AreaAndRim;
  std::int64_t point_bytes() const { return steep.bytes() + steep_rim[0].bytes() + steep_rim[1].bytes(); }
};

/// Lattice rows that are spread together.
constexpr int kBatchRows = 8;

/// Grid rows in ascending order, each [grid_cols, padded] numbers. It holds the rows that are not yet
/// complete, as many as one lattice row reaches.
template <typename Real>
class RowSpreader {
 public:
  explicit RowSpreader(const SpreadProblem<Real>& problem);
  /// Grid row m, until the next call; m must grow from call to call.
  const Real* row(std::int64_t m);

  // For the kernels that are compiled once per instruction set.
  std::int64_t row_size() const { return problem.grid_cols * problem.functions->padded; }
  Real* open_row(std::int64_t entry) { return open.data() + entry % open_rows * row_size(); }
  const SpreadProblem<Real>& problem;
  LatticeRow lattice_rows[kBatchRows];
  bool rim[kBatchRows] = {};                   ///< whether a lattice row's rim has n_y ≠ 0
  FftVector<Real> sources;                     ///< [sources, padded] of a block of one lattice row
  FftVector<Real> block_rows[kBatchRows];      ///< [block_cols, padded] lattice rows spread along x
  FftVector<Real> block_rim_rows[kBatchRows];  ///< the same for the ∂K/∂y part
  std::int64_t block_cols = 0;                 ///< grid columns done at a time
  std::int64_t open_rows;                      ///< grid rows held
  std::int64_t open_begin = 0;                 ///< entry of gather_y of the first of them
  FftVector<Real> open;        ///< [open_rows, grid_cols, padded] entry e in slot e % open_rows
  std::int64_t next = 0;       ///< first lattice row not yet spread
  std::size_t next_steep = 0;  ///< first of the steep facets' points not yet spread
  std::array<std::size_t, 2> next_steep_rim = {};  ///< the same of the steep rim's
};

}  // namespace micro
