#pragma once

#include <cstdint>

#include "height/height_field.h"

namespace micro::testing {

/// A Gaussian random surface without Fourier transforms: the sum of `waves` cosines of random direction,
/// wavelength and phase, whose correlation is rms²·exp(−x²/τx² − y²/τy²) over the ensemble. All lengths in
/// µm.
struct GaussianSurface {
  Eigen::Index rows = 48, cols = 64;
  double dx = 0.11, dy = 0.11;
  double rms = 0.3, tau_x = 3, tau_y = 3;
  int waves = 200;
};
HeightField make_gaussian_surface(const GaussianSurface& description, std::uint64_t seed);

/// Takes out each point with probability `fraction`.
HeightField with_missing(HeightField surface, double fraction, std::uint64_t seed);

}  // namespace micro::testing
