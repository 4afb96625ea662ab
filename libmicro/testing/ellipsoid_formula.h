#pragma once

#include "core/grid.h"
#include "distribution/slope_space.h"

namespace micro::testing {

/// [Dong15 Eq. 10] as printed, in 50 decimal digits, 1/sr.
double printed_ellipsoid_D(const EllipsoidParameters& parameters, const Vec3& m);

/// [Dong15 Eq. 14] as printed, in 50 decimal digits.
double printed_ellipsoid_G1(const EllipsoidParameters& parameters, const Vec3& u);

}  // namespace micro::testing
