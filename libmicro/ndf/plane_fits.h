#pragma once

#include "ndf/gaussian_passes.h"

namespace micro {

/// Least reciprocal condition (2-norm) of a fit that is trusted.
constexpr double kLeastCondition = 1e-9;

/// Gaussian moments of the windows around the points of a block, in units of σ: of the mask (m…) and of the
/// heights (z…).
struct BlockMoments {
  StripBlock m[3];   ///< ⟨1⟩, ⟨y⟩, ⟨y²⟩
  StripBlock mx[2];  ///< ⟨x⟩, ⟨xy⟩
  StripBlock mxx;    ///< ⟨x²⟩
  StripBlock z[2];   ///< ⟨z⟩, ⟨yz⟩
  StripBlock zx;     ///< ⟨xz⟩
};

/// Planes fitted to moments.
struct BlockFits {
  StripBlock zx, zy;  ///< slopes per σ
  StripBlock margin;  ///< above 0 only where the fit's reciprocal condition is at least kLeastCondition
};

/// Solves the 3×3 normal equations at every point of a block, the constant eliminated first. `margin` comes
/// from a lower bound on the moment matrix's least eigenvalue: with the mean position µ = (⟨x⟩, ⟨y⟩)/⟨1⟩ and
/// the centred second moments S the matrix is L·diag(⟨1⟩, S)·Lᵀ, and ‖L⁻¹‖² ≤ 2(1 + µ²).
BlockFits fit_planes(const BlockMoments& moments);

/// The same question for one point, answered by the eigenvalues: is the reciprocal condition at least
/// kLeastCondition?
bool well_conditioned(const BlockMoments& moments, std::size_t row, std::size_t column);

}  // namespace micro
