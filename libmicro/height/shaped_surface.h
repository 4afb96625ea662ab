#pragma once

#include "height/synthetic_grid.h"

namespace micro {

/// A profile of one coordinate, t = (x cos φ + y sin φ)/period: its wave vector points along φ =
/// `orientation`, its grooves run at right angles to it.
struct Grating {
  double period = 4;       ///< µm
  double depth = 0.2;      ///< µm, peak to valley
  double orientation = 0;  ///< radians from +x towards +y
};

/// z = (depth/2) sin 2πt. With periodic borders the period must fit the patch: InputError otherwise, naming
/// the nearest that does. The same holds for the two below.
HeightField sinusoid_surface(const SyntheticGrid& grid, const Grating& grating, Border border = Border::Open);

/// A blazed grating, z = depth·(t − ⌊t⌋): facets at the blaze angle atan(depth/period), vertical returns.
HeightField blazed_surface(const SyntheticGrid& grid, const Grating& grating, Border border = Border::Open);

/// A two-level grating: z = depth where t − ⌊t⌋ < duty, 0 elsewhere; 0 ≤ duty ≤ 1.
HeightField two_level_surface(const SyntheticGrid& grid, const Grating& grating, double duty,
                              Border border = Border::Open);

/// z = slope_x·x + slope_y·y.
HeightField plane_surface(const SyntheticGrid& grid, double slope_x, double slope_y);

/// A vertical step through the middle of the patch: z = height where x cos φ + y sin φ is beyond the
/// middle's, 0 elsewhere (rounded outwards by one cell, as every vertical wall on a grid is).
HeightField step_surface(const SyntheticGrid& grid, double height, double orientation);

/// A single facet: the plane of those slopes in a square of `side` µm about the middle of the patch, nothing
/// around it (all missing). Throws InputError if no whole cell fits into the square.
HeightField facet_surface(const SyntheticGrid& grid, double side, double slope_x, double slope_y);

}  // namespace micro
