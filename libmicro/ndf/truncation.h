#pragma once

#include "height/height_field.h"

namespace micro {

/// Largest |slopes| that the fits of a surface gave.
struct SlopeBounds {
  double zx = 0, zy = 0;
};

/// A bound on how far the slopes of locally weighted plane fits move when the Gaussian window is cut at
/// ±radius points (GaussianTaps) instead of reaching over the whole surface, for windows without a missing
/// point; beside missing points it grows as their fit's condition.
///
/// Fits are exact on planes, so only the residual r = z − plane of the cut fit enters, and only outside the
/// window: with u = |x| + |x̄|, v = |y| + |ȳ| in units of σ,
///   |Δzx| ≤ Σ_outside w·u·|r| / (σ·S_xx),  |r| ≤ 2·max|z| + σ·(|zx|·u + |zy|·v),
/// S_xx the least weighted variance of x over all windows, those cut by the border too; likewise zy. The
/// outside sum is Σ_tail,x·Σ_all,y + Σ_all,x·Σ_tail,y: the window is cut along both axes.
/// sigma in µm; returns the larger of the two. 0 where every window holds the whole surface.
double slope_truncation_bound(const HeightField& surface, double sigma, const SlopeBounds& slopes);

}  // namespace micro
