#pragma once

#include <vector>

#include "core/grid.h"
#include "kirchhoff/disk_transform.h"

namespace micro {

/// Memory that may serve one surface after the other; nothing in it outlives a call.
template <typename Real>
struct SpectrumMemory {
  FftVector<std::complex<Real>> rows;
};

struct SpectrumDensity {
  std::vector<Grid<float>> tables;  ///< [λ_q] [size, size] 1/sr
  SpectralWork work;
};

/// Bytes of spectra that at least have to be held at once.
std::int64_t least_spectra_bytes(const HeightField& surface, const DiskGrid& grid, double shortest,
                                 const SpectralChoice& choice);

/// D_K on every node of the table at each λ_q (µm, ascending): see spectrum.h. `choice` must suit the
/// shortest. Throws InputError if not one triangle is there, or if the lattice has so many points that it
/// would take hours.
template <typename Real>
SpectrumDensity transform_spectrum(const HeightField& surface, const DiskGrid& grid,
                                   const std::vector<double>& lambda_q, const SpectralChoice& choice,
                                   SpectrumMemory<Real>& memory);

}  // namespace micro
