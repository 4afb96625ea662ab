#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/estimate.h"
#include "kirchhoff/error_sample.h"
#include "kirchhoff/spectral.h"

namespace micro {

/// D_K at one of many wavelengths.
struct SpectrumTable {
  Grid<float> density;  ///< [size, size] 1/sr
  ErrorSample error;    ///< of this table, measured against `exact`
  bool reached = false;
};

/// D_K on a whole table at many wavelengths, and how well that went.
struct KirchhoffSpectrum {
  std::vector<SpectrumTable> tables;  ///< one for each λ_q
  bool shared = true;                 ///< whether one pass over the surface served all of them
  SpectralChoice choice;              ///< what the first pass, over all wavelengths, was computed with
  SpectralWork work;                  ///< of that pass; fft_length: of the rows
  Cost cost;  ///< with the measurement of the error; evaluations are complex transforms
};

/// D_K tables at many effective wavelengths in one pass over the surface. The images φ_k(h) of the spectral
/// estimator (disk_transform.h) do not depend on |q|, nor do their spectra, so they are made once, for the
/// shortest wavelength, on a grid of wave numbers just fine enough for the patch (2π/(1.5·side)). Each
/// wavelength then interpolates them at its own nodes (Kaiser–Bessel, the images divided by its transform
/// beforehand) and sums over as many of the nested terms as its q_z take.
///
/// Memory: 256 MiB for spectra, or what 8 terms take; 4 bytes per node and wavelength for the tables; a few
/// MiB for each thread; where the terms do not fit into one pass (height ranges of many micrometres, patches
/// of hundreds), another 512 MiB for partial sums. A patch so large that 8 terms take more than `most_bytes`
/// is done one wavelength after the other by SpectralSolver.
class SpectrumSolver {
 public:
  /// Tables on `grid` at each of `lambda_q` (µm, ascending), with the promises of SpectralSolver for each of
  /// them. Throws InputError as SpectralSolver does, or if there is no wavelength or they do not ascend.
  SpectrumSolver(const DiskGrid& grid, std::vector<double> lambda_q, double tol,
                 std::int64_t most_bytes = std::int64_t{1} << 30);
  ~SpectrumSolver();
  SpectrumSolver(SpectrumSolver&&) noexcept;

  /// Computes the tables and measures the error of each on a few nodes drawn with `seed`, on more where those
  /// look bad; those wavelengths that miss the tolerance are computed again more finely. Throws InputError
  /// as SpectralSolver does.
  KirchhoffSpectrum operator()(const HeightField& surface, std::uint64_t seed = 0);

  const DiskGrid& grid() const { return grid_; }
  const std::vector<double>& lambda_q() const { return lambda_q_; }

 private:
  struct Memory;
  KirchhoffSpectrum together(const HeightField& surface, SpectralChoice choice, std::uint64_t seed);
  KirchhoffSpectrum one_by_one(const HeightField& surface, std::uint64_t seed) const;

  DiskGrid grid_;
  std::vector<double> lambda_q_;
  double tol_;
  std::int64_t most_bytes_;
  std::unique_ptr<Memory> memory_;
};

}  // namespace micro
