#pragma once

#include <cstdint>

#include "height/height_field.h"

namespace micro::testing {

/// A Gaussian surface: standard deviation σ, correlation σ² exp(−x²/τ_x² − y²/τ_y²). All lengths in µm.
struct GaussianStatistics {
  double sigma = 0, tau_x = 0, tau_y = 0;
};

/// rows × cols heights of one such surface: white noise (one number per node, of `seed`), each row and each
/// column averaged with weights ∝ exp(−2x²/τ²), the square root of the correlation under convolution. For
/// τ ≥ 2·pitch the correlation is the continuous one to 1e-8, and nothing is periodic.
HeightField gaussian_surface(Eigen::Index rows, Eigen::Index cols, double dx, double dy,
                             const GaussianStatistics& statistics, std::uint64_t seed);

}  // namespace micro::testing
