#pragma once

#include <optional>

#include "distribution/scatter.h"
#include "fit/normal_equations.h"

namespace micro {

/// Where a fit may start: the frame that fits best when the model is made linear. D^{−1/2} of the ellipsoid
/// NDF is a quadratic form in the normal, hᵀ·B·h, and −ln(D·m_z⁴) of Beckmann's a quadratic function of the
/// slope: six unknowns and linear least squares, each node with the weight that an error of its D has in the
/// fit. On an exact table that is the answer, however thin, turned or skewed the lobe; the height is free, so
/// that a part of the energy does not matter. `near`: any frame, in whose coordinates it is solved. Nothing
/// if the quadric that fits best is not a lobe.
std::optional<SlopeFrame> quadric_start(const TableNodes& nodes, const SlopeFrame& near, FitModel model,
                                        Weighting weighting);

}  // namespace micro
