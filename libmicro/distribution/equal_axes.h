#pragma once

#include <Eigen/Core>

#include "distribution/slope_space.h"

namespace micro {

/// R = R_x(θ_x)R_y(θ_y)R_z(θ_z) [Dong15 Eq. 12]: its rows are the ellipsoid's axes.
Eigen::Matrix3d rotation(const EllipsoidParameters& parameters);

/// Lengths of the ellipsoid's axes, the longest first, up to a common factor, and their directions: the
/// singular values of F and its right singular vectors, FᵀF = B/B_zz.
struct PrincipalAxes {
  Eigen::Matrix3d direction;  ///< columns
  Vec3 length;
};
PrincipalAxes principal_axes(const SlopeFrame& frame);

/// F = [L, 0; −tᵀ, 1] of a frame, L upper here: |F·a| is what a unit vector a would have for length.
Eigen::Matrix3d axes_matrix(const SlopeFrame& frame);

/// Which axes are equally long, so that turning them into one another changes nothing and an angle has no
/// meaning.
enum class EqualAxes { None, TwoLongest, TwoShortest, All };

/// Canonical parameters where these axes count as equal, their length being the mean one; smooth in the
/// frame. Equal axes may be turned so that an ellipsoid of revolution's own axis is the one nearest n, as
/// long as it is within 54.7° of n (m_z² ≥ 1/3): then α_x = α_y and θ_z = 0. One that lies lower has a width
/// equal to the third axis, which is turned as near to n as may be: α_y = 1 and θ_x = 0, or α_x = 1 and θ_y =
/// 0. A sphere has no angles.
EllipsoidParameters canonical_parameters(const SlopeFrame& frame, EqualAxes equal);

}  // namespace micro
