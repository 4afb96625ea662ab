#pragma once

#include <functional>

#include "error_vs_time/curve.h"

namespace micro::bench {

/// Part "texture"; `error_core_free` is a second measure:
///   "texel"            a texel of about asked independent normals on a Gaussian surface (rms 0.3 µm, τ 3
///   µm): standard
///                      deviation of the logarithm of its mean width; second, its bias against the whole
///                      area's fit; seconds a texel
///   "texel predicted"  the standard deviation that texels themselves predict
///   "separable hann", "separable none", "joint hann"   texture from a strip across and one along of asked
///   texels:
///                      root mean square error of its autocorrelation at lags up to 20 against the strips'
///                      law; second, relative error of the variance; seconds for 256² texels
///   "whole", "parts"   texture of asked texels a side: relative error of the variance against the model's,
///   second, of
///                      the mean in standard deviations; seconds
///   "levels"           64 lobes refitted as one: KL divergence, second, that of averaged parameters; asked =
///   spread of
///                      centres in widths
void texture_curves(const std::function<void(const CurvePoint&)>& report);

}  // namespace micro::bench
