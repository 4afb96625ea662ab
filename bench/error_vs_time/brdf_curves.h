#pragma once

#include <functional>

#include "error_vs_time/curve.h"

namespace micro::bench {

/// Part "brdf", on lobes instead of surfaces, of copper at 0.55 µm:
///   "albedo"      directional albedo at 60 degrees to a tolerance, asked: absolute error against 1e-6
///   "table"       f of a tabulated distribution of N nodes a side, asked = N: relative L2 over the model's
///   own
///                 samples; seconds for 90 × 90 × 180 bins
///   "spectrum"    the colour at 60 degrees from asked wavelengths: largest difference in linear sRGB to 200
void brdf_curves(const std::function<void(const CurvePoint&)>& report);

}  // namespace micro::bench
