#pragma once

#include <vector>

#include "core/grid.h"

namespace micro {

/// n half directions spread evenly over the part |h_xy| ≤ extent of the projected hemisphere: Vogel's spiral,
/// every direction with the same share of the disk's area, none at the centre or on the rim. The first
/// direction is the nearest to the normal. Throws InputError unless n ≥ 1 and 0 < extent ≤ 1.
std::vector<Vec3> spread_directions(int n, double extent = 1);

}  // namespace micro
