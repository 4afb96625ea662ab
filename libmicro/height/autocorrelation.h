#pragma once

#include "height/height_field.h"

namespace micro {

/// Normalised autocorrelation ρ of the heights about their mean, for lags up to half the surface each way:
/// ρ(l) = [Σ z(p) z(p+l) / pairs(l)] / ⟨z²⟩ over the pairs of valid points l apart, so that missing data
/// neither bias it nor count as zeros. One half plane suffices: ρ(−l) = ρ(l).
struct Autocorrelation {
  Grid<double> rho;       ///< [rows/2 + 1, 2·(cols/2) + 1]; NaN where no pair of points is that lag apart
  Eigen::Index zero = 0;  ///< column of lag 0: rho(j, zero + i) has lag (i dx, j dy)
  double dx = 0, dy = 0;  ///< µm
};

/// Two or four real Fourier transforms of 1.5 times the surface each way; about 60 bytes per point. On a flat
/// or empty surface every value is NaN.
Autocorrelation autocorrelation(const HeightField& surface);

/// Lengths in µm where the autocorrelation has decayed; NaN where it does not within half the surface.
struct CorrelationLengths {
  double Sal;     ///< ISO 25178-2: the shortest lag on the border of the central region where ρ ≥ 0.2
  double Str;     ///< ISO 25178-2: Sal over the longest such lag, 0 … 1 (isotropic); none of a profile
  double along;   ///< ρ = 1/e along `direction`
  double across;  ///< ρ = 1/e at right angles to it
};

/// `direction`: radians from +x towards +y; NaN stands for 0, so that along is x and across is y.
CorrelationLengths correlation_lengths(const Autocorrelation& acf, double direction);

}  // namespace micro
