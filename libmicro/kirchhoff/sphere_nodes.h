#pragma once

#include <cstdint>
#include <vector>

#include "core/fft.h"
#include "kirchhoff/term_spectra.h"

namespace micro {

/// c_k(q_z) on equidistant q_z, for linear interpolation: [entries, 2, padded] = Re, Im.
template <typename Real>
struct TermCoefficients {
  double low = 0;    ///< rad/µm, q_z of entry 0
  double per_q = 0;  ///< entries per rad/µm
  int entries = 0;   ///< ≥ 2
  int padded = 0;    ///< terms
  FftVector<Real> data;
};

/// For each node of a table along one axis, the wave numbers that its value is interpolated from, with what
/// takes the gridding kernel's transform out.
template <typename Real>
struct NodeStencils {
  int width = 0;
  std::vector<std::int32_t> start;  ///< [nodes] ascending, index of the first wave number
  std::vector<Real> weight;         ///< [nodes, width]
};

/// Nodes k·spacing, k = first … last.
template <typename Real>
NodeStencils<Real> make_node_stencils(const SpectrumAxis& axis, double spacing, int first, int last);

/// A piece of one table: nodes k_x = kx_begin … kx_end−1 (k_x ≥ 0) and k_y = ky_begin … ky_end−1 on the
/// sphere of radius |q|, and the same with q_⊥ turned round.
template <typename Real>
struct SphereTile {
  const TermColumns<Real>* columns;
  const TermCoefficients<Real>* coefficients;
  int terms;                    ///< to be summed, a multiple of kTermLanes
  const Real* scale;            ///< [padded] factor on Â_k: |q|², or 1 on I[1]
  const NodeStencils<Real>* x;  ///< of k_x = 0 …
  const NodeStencils<Real>* y;  ///< of k_y = −half …
  std::int64_t y_reach;         ///< the columns' first row is −y_reach
  double sphere, spacing;       ///< |q|² in rad²/µm², nodes' distance in rad/µm
  int half;
  int kx_begin, kx_end, ky_begin, ky_end;
};

/// Reusable memory of a tile and its outcome.
template <typename Real>
struct TileMemory {
  FftVector<Real> row, along_x;
  FftVector<Real> field;  ///< [kx, ky, 4] Re F(q), Im F(q), Re F(q'), Im F(q'), q' = (−q_⊥, q_z), in µm
};

/// Computes Σ_k c_k(q_z) (|q|² Â_k + R̂_k) on a tile's nodes. Nodes beyond the horizon are left as they are.
void evaluate_tile(const SphereTile<float>& tile, TileMemory<float>& memory);
void evaluate_tile(const SphereTile<double>& tile, TileMemory<double>& memory);

}  // namespace micro
