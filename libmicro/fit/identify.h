#pragma once

#include <string>

#include "fit/normal_equations.h"

namespace micro {

/// What a table tells about a frame's five coordinates.
struct Identified {
  Matrix5 inverse;   ///< of the Gram matrix; only where nothing is free
  std::string free;  ///< the combinations of coordinates that are free, in words; empty if none is
};

/// A combination is free if the Gram matrix, which in the frame's own coordinates is naturally well
/// conditioned, all but vanishes along it.
Identified identify(const Matrix5& gram);

/// The combination of coordinates that a covariance of steps knows worst, in words, if that is to more than a
/// tenth of a width: then what is left out of the first order, such as the turn of a needle times the unknown
/// of its centre along it, may exceed the other errors. Empty otherwise.
std::string barely_known(const Matrix5& step_covariance);

/// Canonical parameters of a frame that is known up to a covariance.
struct Canonical {
  EllipsoidParameters parameters;
  Matrix5 covariance;  ///< of (α_x, α_y, θ_x, θ_y, θ_z)
  bool round = false;  ///< α_x = α_y within three standard errors: θ_z has no meaning, and is 0
};
Canonical canonical_with_covariance(const SlopeFrame& frame, const Matrix5& step_covariance);

}  // namespace micro
