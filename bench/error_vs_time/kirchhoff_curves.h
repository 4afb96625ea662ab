#pragma once

#include <functional>

#include "error_vs_time/curve.h"
#include "error_vs_time/surfaces.h"

namespace micro::bench {

/// D_K on all nodes of the 1025² table at λ_q = 0.555 µm, out to the first false order: each estimator over
/// its tolerances, looser ones first, until one takes more than `most_seconds`. Error and time as
/// docs/accuracy.md defines them. Hands every point to `report` as soon as it is there.
void kirchhoff_curves(const NamedSurface& named, double most_seconds,
                      const std::function<void(const CurvePoint&)>& report);

}  // namespace micro::bench
