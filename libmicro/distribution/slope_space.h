#pragma once

#include <cmath>

#include "core/grid.h"

namespace micro {

/// The slope of a normal is the gradient of the height field that has it, (−m_x/m_z, −m_y/m_z): the upper
/// hemisphere is the whole plane of slopes. dω = m_z³ d²slope.
inline Vec2 slope_of(const Vec3& m) {
  return -m.head<2>() / m.z();
}

/// The upper unit normal of a slope; slopes up to 1e300 don't overflow.
inline Vec3 normal_of(const Vec2& slope) {
  const double norm = std::hypot(slope.x(), slope.y(), 1.);
  return {-slope.x() / norm, -slope.y() / norm, 1 / norm};
}

/// Location and scale of an elliptical distribution of slopes: slope = centre + L·v, where v is distributed
/// round. L is lower triangular with a positive diagonal, the scale is Σ = L·Lᵀ (for GGX with t = 0 its
/// eigenvalues are α_x², α_y²).
struct SlopeFrame {
  Vec2 centre = {0, 0};  ///< t
  double l11 = 1, l21 = 0, l22 = 1;

  /// v of a slope.
  Vec2 whiten(const Vec2& slope) const {
    const double v1 = (slope.x() - centre.x()) / l11;
    return {v1, (slope.y() - centre.y() - l21 * v1) / l22};
  }
  /// The slope of v.
  Vec2 unwhiten(const Vec2& v) const {
    return {centre.x() + l11 * v.x(), centre.y() + l21 * v.x() + l22 * v.y()};
  }
  Eigen::Matrix2d scale() const {
    return (Eigen::Matrix2d() << l11 * l11, l11 * l21, l11 * l21, l21 * l21 + l22 * l22).finished();
  }
};

/// The ellipsoid NDF's own parameters [Dong15 Eqs. 11, 12]: A = diag(α_x, α_y, 1)·R_x(θ_x)R_y(θ_y)R_z(θ_z),
/// angles in radians. They are not unique: several give the same distribution.
struct EllipsoidParameters {
  double alpha_x = 0.1, alpha_y = 0.1;
  double theta_x = 0, theta_y = 0, theta_z = 0;
};

/// The ellipsoid's place in slope space. With B = AᵀA and C = B⁻¹ it has centre t = C_xx⁻¹c_x = −b/B_zz and
/// scale C_xx⁻¹/B_zz. Throws InputError unless the widths are positive and all numbers finite.
SlopeFrame slope_frame(const EllipsoidParameters& parameters);

/// The inverse, made unique: the third axis of the ellipsoid is the one nearest n, α_x ≥ α_y, θ_z in (−π/2,
/// π/2], and 0 where α_x = α_y. Both widths are relative to that third axis. Axes of one length:
/// equal_axes.h.
EllipsoidParameters canonical_parameters(const SlopeFrame& frame);

}  // namespace micro
