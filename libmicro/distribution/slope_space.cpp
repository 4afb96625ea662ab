#include "distribution/slope_space.h"

#include <sstream>

#include "core/error.h"
#include "distribution/equal_axes.h"

namespace micro {
namespace {

using Mat3 = Eigen::Matrix3d;

void require_valid(const EllipsoidParameters& p) {
  const bool finite = std::isfinite(p.alpha_x) && std::isfinite(p.alpha_y) && std::isfinite(p.theta_x) &&
                      std::isfinite(p.theta_y) && std::isfinite(p.theta_z);
  if (finite && p.alpha_x > 0 && p.alpha_y > 0) return;
  std::ostringstream text;
  text << "an ellipsoid needs positive widths and finite angles, not alpha (" << p.alpha_x << ", "
       << p.alpha_y << "), theta (" << p.theta_x << ", " << p.theta_y << ", " << p.theta_z << ")";
  throw InputError(text.str());
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

}  // namespace micro
