#pragma once

#include <cstdint>

#include "distribution/disk_table.h"
#include "height/height_field.h"
#include "kirchhoff/coherence.h"

namespace micro {

/// An a-posteriori measurement of a table's error against `exact` on a few nodes, drawn by importance: in
/// turn in proportion to D², to D² without the coherent core, to D (an error of the field, evenly spread,
/// makes Δ² ∝ D), and evenly among significant directions (D ≥ 1e-8 of the peak). It is made of sums, so that
/// a directory's samples add up to one sharper statement.
///
/// The core is |h_xy| within two resolution cells, λ_q/(2L) each, L the patch's shorter side.
struct ErrorSample {
  std::int64_t nodes = 0;            ///< drawn
  double squared = 0;                ///< Σ Δ²/(p ΣD²), Δ = D − D*, p the probability of the node
  double squared_core_free = 0;      ///< the same outside the core, ΣD² too
  std::int64_t significant = 0;      ///< of the nodes drawn evenly,
  std::int64_t significant_bad = 0;  ///< those with |Δ| > 30·tol·D*

  /// Estimate of (Σ(D − D*)²/ΣD*²)^½ over the table.
  double error() const;
  /// The same without the coherent core.
  double error_core_free() const;
  /// Within tol in both measures, and not more than half of the significant directions off by more than
  /// 30·tol.
  bool within(double tol) const;

  ErrorSample& operator+=(const ErrorSample& other);
};

/// Draws `nodes` nodes of a window's table of D_K (1/sr) on `grid` at λ_q, or takes all if it has no more;
/// the draw depends on the table and on `seed` alone. A table without any D > 0 gives an empty sample. `Real`
/// is float or double.
template <typename Real>
ErrorSample sample_error(const Window& window, const DiskGrid& grid, const Grid<Real>& density,
                         double lambda_q, double tol, int nodes, std::uint64_t seed);

/// Radius of the coherent core in units of |h_xy|: two resolution cells.
double coherent_core(const HeightField& surface, double lambda_q);

}  // namespace micro
