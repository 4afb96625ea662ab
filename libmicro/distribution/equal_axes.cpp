#include "distribution/equal_axes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

namespace micro {
namespace {

using Mat3 = Eigen::Matrix3d;

/// Angles of R, whose rows are the axes: R = (c_y c_z, −c_y s_z, s_y; …, −s_x c_y; …, c_x c_y).
EllipsoidParameters parameters_of(double alpha_x, double alpha_y, Vec3 r1, Vec3 r3) {
  if (r3.z() < 0) r3 = -r3;
  if (r1.x() < 0 || (r1.x() == 0 && r1.y() > 0)) r1 = -r1;
  const Vec3 r2 = r3.cross(r1);
  return {alpha_x, alpha_y, std::atan2(-r2.z(), r3.z()), std::atan2(r1.z(), std::hypot(r1.x(), r1.y())),
          std::atan2(-r1.y(), r1.x())};
}

/// Of an ellipsoid of revolution whose own axis is `single` (unit vector), longer than the others by `ratio`.
EllipsoidParameters of_revolution(const Vec3& single, double ratio) {
  const double z = single.z();
  EllipsoidParameters p;
  if (z * z >= 1. / 3) {
    // Any axis will do for the first: the one that needs no θ_z.
    p = parameters_of(1 / ratio, 1 / ratio, Vec3(z, 0, -single.x()).normalized(), single);
    p.theta_z = 0;
    return p;
  }
  const Vec3 third = (Vec3::UnitZ() - z * single).normalized();
  p = ratio >= 1 ? parameters_of(ratio, 1, single, third)
                 : parameters_of(1, ratio, single.cross(third), third);
  (ratio >= 1 ? p.theta_x : p.theta_y) = 0;
  return p;
}

EllipsoidParameters canonical_of(const PrincipalAxes& axes, const SlopeFrame& frame, EqualAxes equal) {
  if (equal == EqualAxes::All) return {1, 1, 0, 0, 0};
  const auto& [direction, length] = axes;
  if (equal != EqualAxes::None) {
    const int single = equal == EqualAxes::TwoLongest ? 2 : 0;
    // The product of all three is |F| = l_11·l_22.
    const double other = std::sqrt(frame.l11 / length[single]) * std::sqrt(frame.l22);
    return of_revolution(direction.col(single), length[single] / other);
  }
  Eigen::Index third;
  direction.row(2).cwiseAbs().maxCoeff(&third);
  const Eigen::Index wide = third == 0 ? 1 : 0, narrow = 3 - third - wide;
  return parameters_of(length[wide] / length[third], length[narrow] / length[third], direction.col(wide),
                       direction.col(third));
}

}  // namespace

Mat3 rotation(const EllipsoidParameters& p) {
  return (Eigen::AngleAxisd(p.theta_x, Vec3::UnitX()) * Eigen::AngleAxisd(p.theta_y, Vec3::UnitY()) *
          Eigen::AngleAxisd(p.theta_z, Vec3::UnitZ()))
      .toRotationMatrix();
}

Mat3 axes_matrix(const SlopeFrame& frame) {
  return (Mat3() << frame.l11, frame.l21, 0, 0, frame.l22, 0, -frame.centre.x(), -frame.centre.y(), 1)
      .finished();
}

/// By one-sided Jacobi rotations [Hestenes58], which keep small singular values relatively accurate.
PrincipalAxes principal_axes(const SlopeFrame& frame) {
  constexpr int kSweeps = 60;
  Mat3 f = axes_matrix(frame), v = Mat3::Identity();
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
  const Vec3 length = f.colwise().norm().transpose();
  std::array<int, 3> order = {0, 1, 2};
  std::sort(order.begin(), order.end(), [&](int a, int b) { return length[a] > length[b]; });
  PrincipalAxes sorted;
  for (int k = 0; k < 3; ++k) {
    sorted.direction.col(k) = v.col(order[static_cast<std::size_t>(k)]);
    sorted.length[k] = length[order[static_cast<std::size_t>(k)]];
  }
  return sorted;
}

EllipsoidParameters canonical_parameters(const SlopeFrame& frame, EqualAxes equal) {
  return canonical_of(principal_axes(frame), frame, equal);
}

EllipsoidParameters canonical_parameters(const SlopeFrame& frame) {
  constexpr double kEqual = 1e-12;
  const PrincipalAxes axes = principal_axes(frame);
  const auto same = [&](int a, int b) { return axes.length[a] - axes.length[b] <= kEqual * axes.length[a]; };
  return canonical_of(axes, frame,
                      same(0, 2)   ? EqualAxes::All
                      : same(0, 1) ? EqualAxes::TwoLongest
                      : same(1, 2) ? EqualAxes::TwoShortest
                                   : EqualAxes::None);
}

}  // namespace micro
