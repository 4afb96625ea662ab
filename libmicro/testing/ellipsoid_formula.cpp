#include "testing/ellipsoid_formula.h"

#include <array>
#include <boost/math/constants/constants.hpp>
#include <boost/multiprecision/cpp_dec_float.hpp>

namespace micro::testing {
namespace {

using Real = boost::multiprecision::cpp_dec_float_50;
using Vector = std::array<Real, 3>;
using Matrix = std::array<Vector, 3>;  // rows

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      c[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
  return c;
}

Vector product(const Matrix& a, const Vector& v) {
  Vector w;
  for (std::size_t i = 0; i < 3; ++i)
    w[i] = a[i][0] * v[0] + a[i][1] * v[1] + a[i][2] * v[2];
  return w;
}

Real dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Real norm(const Vector& a) {
  return sqrt(dot(a, a));
}

Matrix rotation(const EllipsoidParameters& p) {
  const Real tx = p.theta_x, ty = p.theta_y, tz = p.theta_z, o = 0, e = 1;
  const Matrix x = {Vector{e, o, o}, Vector{o, cos(tx), -sin(tx)}, Vector{o, sin(tx), cos(tx)}};
  const Matrix y = {Vector{cos(ty), o, sin(ty)}, Vector{o, e, o}, Vector{-sin(ty), o, cos(ty)}};
  const Matrix z = {Vector{cos(tz), -sin(tz), o}, Vector{sin(tz), cos(tz), o}, Vector{o, o, e}};
  return product(product(x, y), z);
}

/// S·R, or S⁻¹·R = A⁻ᵀ.
Matrix scaled(Matrix r, const Real& sx, const Real& sy) {
  for (std::size_t j = 0; j < 3; ++j) {
    r[0][j] *= sx;
    r[1][j] *= sy;
  }
  return r;
}

Vector vector(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

}  // namespace

double printed_ellipsoid_D(const EllipsoidParameters& p, const Vec3& m) {
  if (m.z() < 0) return 0;
  const Matrix r = rotation(p);
  const Real ax = p.alpha_x, ay = p.alpha_y;
  const Matrix a = scaled(r, ax, ay), inverse_transposed = scaled(r, 1 / ax, 1 / ay);
  const Vector n = {0, 0, 1};
  const Real fourth = pow(norm(product(inverse_transposed, vector(m))), 4);
  return static_cast<double>(1 /
                             (boost::math::constants::pi<Real>() * ax * ay * norm(product(a, n)) * fourth));
}

double printed_ellipsoid_G1(const EllipsoidParameters& p, const Vec3& u) {
  const Matrix a = scaled(rotation(p), p.alpha_x, p.alpha_y);
  const Vector an = product(a, Vector{0, 0, 1}), au = product(a, vector(u));
  const Real g = 2 * dot(an, an) * abs(Real(u.z())) / (norm(an) * norm(au) + dot(au, an));
  return g < 1 ? static_cast<double>(g) : 1;
}

}  // namespace micro::testing
