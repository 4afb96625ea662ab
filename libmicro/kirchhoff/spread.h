#pragma once

#include <cstdint>

#include "core/fft.h"
#include "kirchhoff/gridding.h"
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

/// What is spread onto the grid that the Fourier transforms read, for every term k at once:
///   g_k(x) = Q² Σ_v area_v φ_k(h_v) K(x − v) − Σ_v φ_k(h_v) (n_v·∇K)(x − v),
/// so that its spectrum is Q² Î[φ_k] − i ∮ (q_⊥·n) φ_k e^{−iq_⊥·x} dl, times the kernel's own: area and rim
/// together.
template <typename Real>
struct SpreadProblem {
  const QuadratureLattice* lattice;
  const FunctionTable<Real>* functions;
  double q_squared;
  std::int64_t grid_cols;  ///< of the grid's rows, before they are folded into a period
  std::int64_t row_begin;  ///< grid row of the first entry of gather_y
  GatherTable<Real> gather_x, gather_x_odd, gather_y;
  ScatterTable<Real> scatter_x;
};

/// Grid rows in ascending order, each [grid_cols, padded] numbers; keeps just as many lattice rows as one
/// needs.
template <typename Real>
class RowSpreader {
 public:
  explicit RowSpreader(const SpreadProblem<Real>& problem);
  /// Grid row m; m must grow from call to call.
  const Real* row(std::int64_t m);

  // For the kernels that are compiled once per instruction set.
  const SpreadProblem<Real>& problem;
  LatticeRow lattice_row;
  FftVector<Real> sources;   ///< [lattice cols, padded]
  FftVector<Real> ring;      ///< [slots, grid_cols, padded] lattice rows spread along x
  FftVector<Real> rim_ring;  ///< the same for the ∂K/∂y part; only slots with `rim` set hold anything
  std::vector<std::uint8_t> rim;  ///< [slots]
  FftVector<Real> result;         ///< [grid_cols, padded]
  std::int64_t next = 0;          ///< first lattice row not yet in the ring
};

}  // namespace micro
