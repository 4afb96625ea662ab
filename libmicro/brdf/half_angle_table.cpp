#include "brdf/half_angle_table.h"

#include <cmath>
#include <numbers>

namespace micro {
namespace {

double middle(std::int64_t i, std::int64_t n) {
  return (static_cast<double>(i) + 0.5) / static_cast<double>(n);
}

}  // namespace

double HalfAngleGrid::theta_h_at(std::int64_t i) const {
  const double root = middle(i, theta_h);
  return root * root * std::numbers::pi / 2;
}

double HalfAngleGrid::theta_d_at(std::int64_t j) const {
  return middle(j, theta_d) * std::numbers::pi / 2;
}

double HalfAngleGrid::phi_d_at(std::int64_t k) const {
  return middle(k, phi_d) * std::numbers::pi;
}

std::pair<Vec3, Vec3> HalfAngleGrid::directions(std::int64_t i, std::int64_t j, std::int64_t k) const {
  const double th = theta_h_at(i), td = theta_d_at(j), pd = phi_d_at(k);
  // h, and what turns with it: the meridian's tangent and the parallel's.
  const Vec3 h(std::sin(th) * std::cos(phi_h), std::sin(th) * std::sin(phi_h), std::cos(th));
  const Vec3 down(std::cos(th) * std::cos(phi_h), std::cos(th) * std::sin(phi_h), -std::sin(th));
  const Vec3 beside(-std::sin(phi_h), std::cos(phi_h), 0);
  const Vec3 across = std::cos(pd) * down + std::sin(pd) * beside;
  return {std::cos(td) * h + std::sin(td) * across, std::cos(td) * h - std::sin(td) * across};
}

}  // namespace micro
