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

/// The combination of coordinates that a covariance of steps knows worst.
struct BarelyKnown {
  double error;       ///< its standard error, widths
  std::string words;  ///< of one known to more than a tenth of a width: then what is left out of the first
                      ///< order, such as the turn of a needle times the unknown of its centre along it, may
                      ///< exceed the other errors. Empty otherwise
};
BarelyKnown barely_known(const Matrix5& step_covariance);

/// Canonical parameters of a frame that is known up to a covariance. Axes of the ellipsoid whose lengths
/// agree within three standard errors count as equal, and the angles that then have no meaning are 0.
struct Canonical {
  EllipsoidParameters parameters;
  Matrix5 covariance;       ///< of (α_x, α_y, θ_x, θ_y, θ_z); NaN for angles without meaning
  std::string meaningless;  ///< these angles and why, in words; empty if there is none
};
Canonical canonical_with_covariance(const SlopeFrame& frame, const Matrix5& step_covariance);

}  // namespace micro
