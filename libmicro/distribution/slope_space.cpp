#include "distribution/slope_space.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numbers>
#include <sstream>

#include "core/error.h"

namespace micro {
namespace {

using Mat3 = Eigen::Matrix3d;

/// R = R_x(θ_x)R_y(θ_y)R_z(θ_z) [Dong15 Eq. 12].
Mat3 rotation(const EllipsoidParameters& p) {
  return (Eigen::AngleAxisd(p.theta_x, Vec3::UnitX()) * Eigen::AngleAxisd(p.theta_y, Vec3::UnitY()) *
          Eigen::AngleAxisd(p.theta_z, Vec3::UnitZ()))
      .toRotationMatrix();
}

void require_valid(const EllipsoidParameters& p) {
  const bool finite = std::isfinite(p.alpha_x) && std::isfinite(p.alpha_y) && std::isfinite(p.theta_x) &&
                      std::isfinite(p.theta_y) && std::isfinite(p.theta_z);
  if (finite && p.alpha_x > 0 && p.alpha_y > 0) return;
  std::ostringstream text;
  text << "an ellipsoid needs positive widths and finite angles, not alpha (" << p.alpha_x << ", "
       << p.alpha_y << "), theta (" << p.theta_x << ", " << p.theta_y << ", " << p.theta_z << ")";
  throw InputError(text.str());
}

/// The principal axes of FᵀF by one-sided Jacobi rotations [Hestenes58], which keep small singular values
/// relatively accurate: columns of `axes` and their lengths.
struct PrincipalAxes {
  Mat3 axes;
  Vec3 length;
};
PrincipalAxes principal_axes(Mat3 f) {
  constexpr int kSweeps = 60;
  Mat3 v = Mat3::Identity();
  bool turned = true;
  for (int sweep = 0; turned && sweep < kSweeps; ++sweep) {
    turned = false;
    for (const auto& [p, q] : {std::array{0, 1}, std::array{0, 2}, std::array{1, 2}}) {
      const double pp = f.col(p).squaredNorm(), qq = f.col(q).squaredNorm(), pq = f.col(p).dot(f.col(q));
      if (std::abs(pq) <= 1e-16 * std::sqrt(pp) * std::sqrt(qq)) continue;
      turned = true;
      const double zeta = (qq - pp) / (2 * pq);
      const double t = std::copysign(1., zeta) / (std::abs(zeta) + std::hypot(1., zeta));
      const double c = 1 / std::hypot(1., t), s = c * t;
      for (Mat3* matrix : {&f, &v}) {
        const Vec3 a = matrix->col(p), b = matrix->col(q);
        matrix->col(p) = c * a - s * b;
        matrix->col(q) = s * a + c * b;
      }
    }
  }
  return {v, f.colwise().norm().transpose()};
}

}  // namespace

SlopeFrame slope_frame(const EllipsoidParameters& p) {
  require_valid(p);
  const Mat3 r = rotation(p);
  // a_k = S·r_k are the columns of A. By a_y × a_z = cof(S)·r_x and so on, what the Schur complement of B
  // would get by subtraction comes out as dot products of g_x and g_y: Σ = [g_x·g_x, g_x·g_y; ·, g_y·g_y].
  const Vec3 s(p.alpha_x, p.alpha_y, 1), cofactor(p.alpha_y, p.alpha_x, p.alpha_x * p.alpha_y);
  const Vec3 ax = s.cwiseProduct(r.col(0)), ay = s.cwiseProduct(r.col(1)), az = s.cwiseProduct(r.col(2));
  const double zz = az.squaredNorm();
  const Vec3 gx = cofactor.cwiseProduct(r.col(1)) / zz, gy = -cofactor.cwiseProduct(r.col(0)) / zz;
  SlopeFrame frame;
  frame.centre = Vec2(-ax.dot(az), -ay.dot(az)) / zz;
  frame.l11 = gx.norm();
  frame.l21 = gx.dot(gy) / frame.l11;
  frame.l22 = p.alpha_x * p.alpha_y / (zz * std::sqrt(zz)) / frame.l11;  // det L = |A|/‖An‖³
  return frame;
}

EllipsoidParameters canonical_parameters(const SlopeFrame& frame) {
  // B/B_zz = [Σ + t·tᵀ, −t; −tᵀ, 1] = FᵀF.
  const Mat3 f = (Mat3() << frame.l11, frame.l21, 0, 0, frame.l22, 0, -frame.centre.x(), -frame.centre.y(), 1)
                     .finished();
  const PrincipalAxes principal = principal_axes(f);
  const Mat3& axes = principal.axes;
  const Vec3& length = principal.length;
  std::array<int, 3> order = {0, 1, 2};
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return std::abs(axes(2, a)) > std::abs(axes(2, b)); });
  const int third = order[0];
  const int wide = length[order[1]] >= length[order[2]] ? order[1] : order[2], narrow = 3 - third - wide;
  Vec3 r3 = axes.col(third), r1 = axes.col(wide);
  if (r3.z() < 0) r3 = -r3;
  EllipsoidParameters p;
  p.alpha_x = length[wide] / length[third];
  p.alpha_y = length[narrow] / length[third];
  constexpr double kRound = 1e-12;
  const bool round = p.alpha_x - p.alpha_y <= kRound * p.alpha_x;
  if (round) r1 = Vec3(r3.z(), 0, -r3.x()).normalized();  // any axis will do: the one that needs no θ_z
  if (r1.x() < 0 || (r1.x() == 0 && r1.y() > 0)) r1 = -r1;
  const Vec3 r2 = r3.cross(r1);
  // R = (c_y c_z, −c_y s_z, s_y; …, −s_x c_y; …, c_x c_y).
  p.theta_x = std::atan2(-r2.z(), r3.z());
  p.theta_y = std::atan2(r1.z(), std::hypot(r1.x(), r1.y()));
  p.theta_z = round ? 0 : std::atan2(-r1.y(), r1.x());
  return p;
}

}  // namespace micro
