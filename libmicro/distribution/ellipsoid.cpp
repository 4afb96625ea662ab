#include "distribution/ellipsoid.h"

namespace micro {
namespace {

/// Smallest z of a sampled normal before it is scaled: slopes stay finite.
constexpr double kSmallest = 1e-150;

}  // namespace

Vec2 HemisphereShape::sample(const Vec2& xi) {
  // |v|² = ξ/(1 − ξ): a uniform point of the hemisphere's shadow.
  const double r = std::sqrt(xi.x() / std::max(1 - xi.x(), 0x1p-53)), phi = 2 * std::numbers::pi * xi.y();
  return {r * std::cos(phi), r * std::sin(phi)};
}

Vec2 HemisphereShape::sample_visible(const Vec3& u, const Vec2& xi) {
  // A visible normal of the sphere is the half vector of u and a direction c that is uniform on the sphere;
  // it is above the horizon for the c of the cap c_z > −u_z [Dupuy23]. Written in 1 ± u_z and 1 ± c_z, since
  // a lobe that leans away has u near −z, where u + c cancels.
  const double across = std::hypot(u.x(), u.y()), norm = std::hypot(across, u.z());
  const double sine = across / norm, cosine = u.z() / norm;
  const double plus = cosine >= 0 ? 1 + cosine : sine * sine / (1 - cosine);
  const double cap = (1 - xi.x()) * plus;  // 1 − c_z
  const double sine_c = std::sqrt(cap * (2 - cap)), phi = 2 * std::numbers::pi * xi.y();
  const double along = sine + sine_c * std::cos(phi), beside = sine_c * std::sin(phi);
  const double z = std::max(xi.x() * plus, kSmallest);  // c_z + u_z
  const Vec2 e = across > 0 ? Vec2(u.x() / across, u.y() / across) : Vec2(1, 0);
  return Vec2(along * e.x() - beside * e.y(), along * e.y() + beside * e.x()) / -z;
}

}  // namespace micro
