#pragma once

#include <numbers>

#include "distribution/distribution.h"
#include "distribution/slope_lobe.h"

namespace micro {

/// The normals of a unit hemisphere: slopes v with density 1/(π(1 + |v|²)²), a bivariate Student-t of two
/// degrees of freedom. It has no second moment.
struct HemisphereShape {
  static double density(double vv, double z) {
    const double q = z * z + vv;
    return std::numbers::inv_pi / (q * q);
  }
  /// A hemisphere of radius 1/√π seen from u, any length: (|u| + u_z)/2, from the front and from below.
  static double visible_area(const Vec3& u) {
    const double across = u.x() * u.x() + u.y() * u.y(), norm = std::sqrt(across + u.z() * u.z());
    return u.z() >= 0 ? (norm + u.z()) / 2 : across / (2 * (norm - u.z()));
  }
  static Vec2 sample(const Vec2& xi);
  static Vec2 sample_visible(const Vec3& u, const Vec2& xi);
};

/// The ellipsoid NDF [Dong15 §8, Eqs. 10–14], made from its place in slope space, where it is exactly a
/// shifted, sheared Student-t: Ellipsoid(slope_frame({alpha_x, alpha_y, theta_x, theta_y, theta_z})).
using Ellipsoid = SlopeLobe<HemisphereShape>;
static_assert(Distribution<Ellipsoid>);

/// GTR2-anisotropic [Burley12], θ = 0.
inline Ellipsoid gtr2_anisotropic(double alpha_x, double alpha_y) {
  return Ellipsoid(slope_frame({alpha_x, alpha_y, 0, 0, 0}));
}

/// GGX [Walter07], Trowbridge–Reitz.
inline Ellipsoid ggx(double alpha) {
  return gtr2_anisotropic(alpha, alpha);
}

}  // namespace micro
