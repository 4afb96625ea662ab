#pragma once

#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/estimate.h"
#include "core/grid.h"
#include "kirchhoff/coherence.h"

namespace micro {

/// Random points of D_K's Monte Carlo estimator. `Single` is the paper's: one point in every triangle (or
/// stratum). `Rotated` uses each point three times, its barycentric coordinates rotated: the three share the
/// centroid, so that the error of first order in the phase cancels.
enum class Draws { Single, Rotated };

/// Monte Carlo estimation of D_K for chosen directions [Dong15 Appendix A].
struct MonteCarlo {
  /// For every direction the standard error of D is to be ≤ tolerance · max(D, D_local), D_local the mean of
  /// D over 4 × 4 parts of the window, i.e. the level about which the dark and bright speckles lie: no
  /// relative error can be asked of the true zeros of D.
  double tolerance = 1e-2;
  /// Points (triangle points times directions) after which it stops and says how far it got; the first pass
  /// is always done.
  double max_points = 1e12;
  std::uint64_t seed = 0;
  Draws draws = Draws::Rotated;
};

/// D_K in one direction.
struct DirectionEstimate {
  double density = 0;         ///< D, 1/sr; unbiased, so that it may be negative where D is near 0
  double standard_error = 0;  ///< 1/sr, rounding included
  double local_mean = 0;      ///< D_local, 1/sr
  int subdivision = 0;        ///< n: every triangle was cut into n² strata
  bool reached = false;       ///< standard_error ≤ tolerance · max(density, local_mean)
};

/// D_K at wave vectors q (rad/µm), mean over the windows weighted by their effective areas. Two independent
/// draws in each of n² strata of each triangle give F̂₁, F̂₂ and the unbiased D = Re(F̂₁F̂₂*)/(4π²A)
/// (|F̂|² is too large by Var F̂); n grows until the tolerance is met. All strata are independent,
/// so the variance is the sum of the squared differences of the halves, stratum by stratum. All directions of
/// one call share their random points: their errors are correlated. The result depends on the seed, not on
/// the number of threads. Phases are kept relative to tiles of 8 × 16 cells, in float where they stay below
/// 64 rad and in double elsewhere; rounding is ≤ 1e-6 of the envelope √(D_local·max(D, D_local)), which
/// counts in the standard errors, so that no tolerance below that is said to be reached (nor more points
/// drawn for it). `error` of the result is the relative error over the list, √(Σ standard_error² / ΣD²); cost
/// counts points. Throws InputError if there is no triangle, or unless tolerance > 0 and q is finite.
Estimate<std::vector<DirectionEstimate>> monte_carlo_density(std::span<const Window> windows,
                                                             std::span<const Vec3> q,
                                                             const MonteCarlo& options);
Estimate<std::vector<DirectionEstimate>> monte_carlo_density(const HeightField& surface,
                                                             std::span<const Vec3> q,
                                                             const MonteCarlo& options);

/// One pass of the estimator over a window.
struct FieldSampling {
  int subdivision = 1;  ///< n: strata per triangle are n²
  std::uint64_t seed = 0;
  std::uint32_t window = 0;  ///< number of the window, so that windows draw different points
  Draws draws = Draws::Rotated;
};

/// Two independent unbiased estimates of F(q) (kirchhoff.h; µm) in one direction.
struct FieldHalves {
  std::complex<double> first, second;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of (Re, Im) of one half, estimated, µm²
  double incoherent = 0;  ///< unbiased Σ|F_part|² over 4 × 4 parts of the window, µm²
};

std::vector<FieldHalves> monte_carlo_field(const Window& window, std::span<const Vec3> q,
                                           const FieldSampling& sampling);

}  // namespace micro
