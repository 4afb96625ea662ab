#pragma once

#include "height/height_field.h"

namespace micro {

/// A surface after a repair, and what the repair did. Both repairs are off unless asked for, as in the paper.
struct Repair {
  HeightField surface;
  Eigen::Index changed = 0;   ///< points filled or rejected
  double largest_change = 0;  ///< µm, see each repair
};

/// Fills each hole with the harmonic surface over it: Laplace's equation ∂²z/∂x² + ∂²z/∂y² = 0 in five-point
/// differences, the valid neighbours given, no slope across the image border. `largest_change` is the largest
/// distance of a filled height from the surface's mean, µm. The cost grows with the number of missing points
/// alone. Throws InputError if no point has a height.
Repair fill_holes(const HeightField& surface);

struct OutlierRule {
  double threshold = 6;     ///< in robust standard deviations
  Eigen::Index radius = 2;  ///< of the square window, points
};

/// Makes outliers missing. A point is one if it lies further from the median of the valid heights in its
/// window than `threshold` robust standard deviations: the larger of 1.4826 × the median absolute deviation
/// inside that window and 1.4826 × the median over the whole surface of the distances from the local median
/// (1.2533 × their mean if that median is 0, as on quantised heights). Points with fewer than four neighbours
/// are left alone; a clump that fills half a window is no outlier. `largest_change` is the largest distance
/// from the local median that was rejected, µm.
Repair reject_outliers(const HeightField& surface, const OutlierRule& rule = {});

}  // namespace micro
