#pragma once

#include <cstdint>
#include <vector>

#include "height/synthetic_grid.h"

namespace micro {

/// A Gaussian random field [Sun02 §4]: normal heights of mean 0 and correlation
/// C(x, y) = rms² exp(−x'²/τ_x² − y'²/τ_y²), where x' and y' are the lag's coordinates along and across the
/// direction `orientation`.
struct GaussianField {
  double rms = 0.3;        ///< µm
  double tau_x = 3;        ///< µm, along the orientation
  double tau_y = 3;        ///< µm, across it
  double orientation = 0;  ///< radians from +x towards +y
};

/// Makes one by a moving average: white noise ∗ exp(−2x'²/τ_x² − 2y'²/τ_y²), whose autocorrelation is C.
/// Open borders: the noise lives on a lattice a third of a correlation length apart (which keeps variance and
/// correlation to 3e-10), sheared so that the kernel separates for every orientation; it reaches as far as
/// the kernel does, so the field is stationary up to the border, and a larger surface of the same seed
/// contains the smaller one. Any τ: cost and memory do not grow with it, below a fifth of the pitch the
/// points are independent, far beyond the patch the surface is a constant. Periodic: the same correlation,
/// wrapped around, imposed in Fourier space on noise at the grid points (another 24 bytes a point); `rms`
/// includes the mean of the patch. Throws InputError unless rms ≥ 0 and the correlation lengths are positive
/// and finite.
HeightField gaussian_surface(const SyntheticGrid& grid, const GaussianField& field, std::uint64_t seed,
                             Border border = Border::Open);

/// The sum of independent Gaussian fields, as on real metal where every scale has its roughness.
HeightField multiscale_surface(const SyntheticGrid& grid, const std::vector<GaussianField>& scales,
                               std::uint64_t seed, Border border = Border::Open);

/// `count` fields with correlation lengths in geometric progression from tau_min to tau_max µm across and
/// `aspect` times as much along the orientation, amplitudes ∝ τ^hurst, together of the given rms.
struct PowerLaw {
  double rms = 0.3;
  double tau_min = 0.3;
  double tau_max = 30;
  int count = 8;
  double hurst = 0.7;
  double aspect = 1;
  double orientation = 0;
};
std::vector<GaussianField> power_law_scales(const PowerLaw& law);

}  // namespace micro
