#pragma once

#include "height/height_field.h"
#include "ndf/plane_fits.h"

namespace micro {

/// Slopes of the locally fitted planes of a surface.
struct SlopeField {
  Grid<double> zx, zy;  ///< [rows, cols] ∂z/∂x, ∂z/∂y; NaN where a point has no normal
  Eigen::Index without_normal =
      0;  ///< points that have a height, but whose neighbours don't determine a plane
  /// Bound on the slopes' error from cutting the window off, where no point of the window is missing
  /// (slope_truncation_bound); beside missing points it grows as the fit's condition.
  double truncation_error = 0;
};

/// Locally weighted linear least squares [Dong15 §5.1]: at every point fits z ≈ a + b·x + c·y with the
/// weights w = exp(−r²/2σ²), missing points weighing 0; zx = b and zy = c.
///
/// A point has a normal if its own height is there and the 3×3 moment matrix (of 1, x/σ, y/σ) has a
/// reciprocal condition of at least kLeastCondition. The fit needs nine Gaussian moments (of 1, x, y, x², xy,
/// y², z, xz, yz), each separable; only what the mask calls for is computed:
///  - window complete: b = ⟨xz⟩/⟨x²⟩, c = ⟨yz⟩/⟨y²⟩, two derivative-of-Gaussian convolutions;
///  - window cut by the border alone: the first six are products of two one-dimensional profiles;
///  - window with a missing point: all nine.
/// Exact to rounding but for the window's cut-off at 7σ (GaussianTaps::kReach).
/// sigma in µm. Throws InputError if σ is below half the pitch: the fit would see its own point alone.
SlopeField local_planes(const HeightField& surface, double sigma);

/// Throws InputError, with the reason, unless σ (µm) is at least half the pitch.
void require_resolved(double sigma, const HeightField& surface);

}  // namespace micro
