#pragma once

#include <vector>

#include "io/hdf5_writer.h"
#include "pipelines/kirchhoff_spectrum.h"

namespace micro {

/// What is said of a spectrum's tables: one number for all, and each one's own.
struct SpectrumNumbers {
  double normalization;                                             ///< mean over wavelengths of ∫D m_z dω
  double rel_error;                                                 ///< the largest
  std::vector<double> normalizations, rel_errors, valid_sin_theta;  ///< [λ]
};

SpectrumNumbers numbers_of(const SpectrumOfScans& spectrum);

/// Writes /ndf/kirchhoff_spectrum (docs/design.md has its layout), table by table.
void write_spectrum(Hdf5Writer& file, const SpectrumOfScans& spectrum);

}  // namespace micro
