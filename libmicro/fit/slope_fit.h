#pragma once

#include "fit/fit.h"

namespace micro {

/// Slopes of one texel's normals, [rows, cols] each; NaN where a point has none.
using SlopeBlock = Eigen::Ref<const Grid<double>, 0, Eigen::OuterStride<>>;

/// Fits the ellipsoid NDF to the normals of a texel, without a table of the disk: the slopes are brought to a
/// round lobe by the most likely frame of a few hundred of them (scatter_step), counted in a table of 33²
/// nodes that resolves it, and fitted there by fit(); the frame found is carried back. So needles and tilted
/// lobes cost the same as round ones and are resolved as well, and what is minimised, Σ(D_k − D)²dω,
/// is measured in the lobe's own frame.
///
/// Neighbouring normals are not independent. The covariance is the clustered sandwich [Liang86] over 4 × 4
/// parts of the texel, which holds as far as the parts are longer than the slopes' correlation. `iterations`
/// and `rel_rms` are those on the table. Status Unresolved: nothing varies (a flat facet), the width is
/// kLeastWidth.
Fit fit_slopes(const SlopeBlock& zx, const SlopeBlock& zy);

/// Widths are not followed below this slope.
constexpr double kLeastWidth = 1e-7;

}  // namespace micro
