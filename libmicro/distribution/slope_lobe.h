#pragma once

#include <algorithm>
#include <cmath>

#include "distribution/slope_space.h"

namespace micro {

/// A distribution of normals whose slopes are distributed as centre + L·v, v round about the origin with the
/// density of `Shape`. Smith's masking and the visible normals follow the affine map exactly: seen from u the
/// slopes weigh (u_z − slope·u_xy)₊ = (u'_z − v·u'_xy)₊ with u' = (Lᵀu_xy, u_z − t·u_xy), so everything is
/// that of the round shape seen from u', which may well lie below the horizon. The cut χ₊(m·n) of [Dong15 Eq.
/// 10] is the horizon of v's hemisphere too: v keeps the sign of m_z.
///
/// Shape gives, all static: `density(vv, z)` in 1/sr for v of m_z = z scaled to |(v·z, z)|, where vv =
/// |v·z|²; `visible_area(u)`, `sample(xi)` and `sample_visible(u, xi)` of v for any vector u.
template <typename Shape>
class SlopeLobe {
 public:
  explicit SlopeLobe(const SlopeFrame& frame)
      : frame_(frame),
        inverse11_(1 / frame.l11),
        inverse22_(1 / frame.l22),
        inverse_determinant_(1 / frame.l11 / frame.l22) {}

  const SlopeFrame& frame() const { return frame_; }

  double D(const Vec3& m) const {
    if (m.z() < 0) return 0;
    const double v1 = (m.x() + frame_.centre.x() * m.z()) * inverse11_;
    const double v2 = (m.y() + frame_.centre.y() * m.z() - frame_.l21 * v1) * inverse22_;
    return inverse_determinant_ * Shape::density(v1 * v1 + v2 * v2, m.z());
  }

  double visible_area(const Vec3& u) const { return Shape::visible_area(seen_from(u)); }

  /// [Dong15 Eq. 14]: clamped, since a lobe that leans away shows less area than the mean plane has.
  double G1(const Vec3& u) const {
    if (!(u.z() > 0)) return 0;
    const double area = visible_area(u);
    return u.z() < area ? u.z() / area : 1;
  }

  Vec3 sample(const Vec2& xi) const { return normal_of(frame_.unwhiten(Shape::sample(xi))); }
  double pdf(const Vec3& m) const { return D(m) * std::max(0., m.z()); }

  Vec3 sample_visible(const Vec3& u, const Vec2& xi) const {
    return normal_of(frame_.unwhiten(Shape::sample_visible(seen_from(u), xi)));
  }
  /// 0 where so little is visible that its area underflows.
  double pdf_visible(const Vec3& u, const Vec3& m) const {
    const double area = visible_area(u);
    return area > 0 ? D(m) * std::max(0., m.dot(u)) / area : 0;
  }

 private:
  Vec3 seen_from(const Vec3& u) const {
    return {frame_.l11 * u.x() + frame_.l21 * u.y(), frame_.l22 * u.y(),
            u.z() - frame_.centre.x() * u.x() - frame_.centre.y() * u.y()};
  }

  SlopeFrame frame_;
  double inverse11_, inverse22_, inverse_determinant_;
};

}  // namespace micro
