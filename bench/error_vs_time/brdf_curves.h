#pragma once

#include <functional>

#include "error_vs_time/curve.h"

namespace micro::bench {

/// Part "brdf", on a round lobe and a needle instead of surfaces, of copper at 0.55 µm, the light at 60
/// degrees; CPU seconds of all threads:
///   "albedo"            directional albedo to a tolerance, asked: absolute error against 1e-6
///   "table"             f of a tabulated distribution of N nodes a side, asked = N: relative L2 over the
///                       model's own samples; seconds for 90 × 90 × 180 bins at three wavelengths
///   "half-angle table"  f of the nearest of N × N × 2N bins, asked = N, of the round lobe: the same error;
///                       seconds to fill the table
///   "D_K albedo"        the same of a perfect mirror under a made surface's D_K (rms 0.3 µm, τ 3 µm,
///                       λ_q 0.5 and 0.6 µm), over the tables and by draws: against 3e-5 over the tables
///   "spectrum"          the colour from asked wavelengths: largest difference in linear sRGB to 200
void brdf_curves(const std::function<void(const CurvePoint&)>& report);

}  // namespace micro::bench
