#pragma once

#include <functional>

#include "error_vs_time/curve.h"

namespace micro::bench {

/// Part "recipes": what textures keep of a brushed and of an isotropic exemplar, surfaces as `microbrdf
/// synth` makes them, 32 × 32 texels of 30 µm; strips are four rows and four columns of them. `surface` is
/// the exemplar, `note` what the row is of: recipe, basis and marginals, or "another piece" of the same
/// finish, which is what so few texels know. `estimator` is the measure, `error` its value as a mean over
/// seeds:
///   "mean"            largest difference of a number's mean, in standard deviations
///   "variance"        largest relative difference of a number's variance
///   "axes"            rms difference of autocorrelations at lags of 1 to 6 texels along each axis
///   "plane"           the same at all lags of up to 4 texels along both
///   "between"         rms difference of the ten correlations between numbers at lag 0
///   "between lagged"  the same at the next texel along x, along y and across
///   "marginals"       largest distance between distribution functions (Kolmogorov–Smirnov)
/// Correlations in space are held against the whole block's, the others against the exemplar's.
void texture_recipes(const std::function<void(const CurvePoint&)>& report);

}  // namespace micro::bench
