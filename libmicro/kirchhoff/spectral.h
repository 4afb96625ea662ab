#pragma once

#include <cstdint>
#include <memory>

#include "core/estimate.h"
#include "kirchhoff/disk_transform.h"
#include "kirchhoff/error_sample.h"

namespace micro {

/// D_K on a whole table, and how well that went.
struct KirchhoffTable {
  DiskTable table;        ///< D_K in 1/sr
  ErrorSample error;      ///< of this table, measured against `exact`
  bool reached = false;   ///< whether `error` is within the tolerance asked for
  SpectralChoice choice;  ///< what it was computed with
  SpectralWork work;
  Cost cost;  ///< with the measurement of the error; evaluations are complex transforms of work.fft_length
              ///< numbers
};

/// The spectral estimator [kirchhoff.h, disk_transform.h], ready for many scans: it keeps its memory between
/// them. One solver serves one thread at a time, and uses all threads of core/parallel.h itself.
class SpectralSolver {
 public:
  /// Tables on `grid` at effective wavelength λ_q (µm) with relative L2 error ≤ tol, over the table and over
  /// the table without its coherent core; among directions with D ≥ 1e-8 of the peak the median relative
  /// error is ≤ 30·tol. Throws InputError unless 0 < tol < 1 and λ_q is positive and finite.
  SpectralSolver(const DiskGrid& grid, double lambda_q, double tol);
  ~SpectralSolver();

  /// Computes a table, measures its error on a few nodes drawn with `seed` (as many as take some 15 % of
  /// the table's time), and refines until that
  /// is within tol or there is nothing left to refine in some ten seconds: then `reached` is false. Throws
  /// InputError if the surface has no triangle, or if its relief is such, or the grid so coarse for this
  /// wavelength, that a table would take many minutes: the message says how many, and how far out the table
  /// may go instead.
  KirchhoffTable operator()(const HeightField& surface, std::uint64_t seed = 0);
  /// The same of a coherent window, tapered or not.
  KirchhoffTable operator()(const Window& window, std::uint64_t seed = 0);

 private:
  struct Memory;
  DiskGrid grid_;
  double lambda_q_, tol_;
  std::unique_ptr<Memory> memory_;
};

/// One table, computed by a solver of its own.
KirchhoffTable spectral_table(const HeightField& surface, const DiskGrid& grid, double lambda_q, double tol);

/// What a tolerance takes on a surface, judged from its slopes before anything is computed.
SpectralChoice choose_spectral(const HeightField& surface, const DiskGrid& grid, double lambda_q, double tol);

/// The next finer choice for a table whose error is `excess` times what it may be: the quadrature's error
/// falls as the fourth power of the subdivision, aliases more slowly; beyond the finest lattice every facet
/// is integrated for itself. The same one if there is none.
SpectralChoice refine(SpectralChoice choice, double excess);

/// Nodes whose exact values take some 15 % of a table's time, more on small surfaces: by operation counts, so
/// that they are always the same.
int checked_nodes(const HeightField& surface, const DiskGrid& grid, const SpectralWork& work);

}  // namespace micro
