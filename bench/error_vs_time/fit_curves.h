#pragma once

#include <functional>

#include "error_vs_time/curve.h"

namespace micro::bench {

/// Parts "fit", "masking" and "sampling", on lobes instead of surfaces:
///   fit, "size"        table of N nodes a side, asked = N: how far the frame found lies from the true one,
///   in widths fit, "histogram"   the same where each node holds the mean over its bin fit, "noise" 129²
///   nodes with additive noise of asked × peak fit, "counts"      129² nodes, histogram of asked normals fit,
///   "steps"       513² nodes after asked Gauss–Newton steps from the start masking, "table"   G1 of a table
///   of N nodes a side, asked = N: root mean square over directions sampling, "table"  density of visible
///   normals of such a table: relative L2 over its samples; seconds for 10⁵
void fit_curves(const std::function<void(const CurvePoint&)>& report);

}  // namespace micro::bench
