#include "distribution/masking_table.h"

#include <algorithm>
#include <numbers>

#include "core/parallel.h"

namespace micro {
namespace {

constexpr int kAzimuths = 128;    // of the whole turn; opposite ones share a projection
constexpr int kElevations = 128;  // steps of x = c/(1 + |c|) from −1 to 1, an even number: c = 0 is a node

/// c of the node k of x.
double cotangent(int k) {
  const double x = 2. * k / kElevations - 1;
  return x / (1 - std::abs(x));
}

/// Masses and first moments below each node c_k, of the slopes s along one direction.
struct Marginal {
  Eigen::ArrayXd mass = Eigen::ArrayXd::Zero(kElevations + 1), moment = mass;

  void add(double s, double m) {
    const double x = s / (1 + std::abs(s));
    const int bin = std::clamp(static_cast<int>((x + 1) * (kElevations / 2)), 0, kElevations - 1);
    mass[bin + 1] += m;
    moment[bin + 1] += m * s;
  }
  void accumulate() {
    for (int k = 1; k <= kElevations; ++k) {
      mass[k] += mass[k - 1];
      moment[k] += moment[k - 1];
    }
  }
};

Marginal project(const SlopePoints& points, double phi) {
  const double e1 = std::cos(phi), e2 = std::sin(phi);
  Marginal marginal;
  for (std::size_t k = 0; k < points.mass.size(); ++k) {
    const double s = e1 * points.v1[k] + e2 * points.v2[k];
    const double variance =
        e1 * e1 * points.spread11[k] + 2 * e1 * e2 * points.spread12[k] + e2 * e2 * points.spread22[k];
    // Two points have the mean and the variance of the surroundings.
    const double spread = std::sqrt(std::max(0., variance)), half = points.mass[k] / 2.;
    marginal.add(s - spread, half);
    marginal.add(s + spread, half);
  }
  marginal.accumulate();
  return marginal;
}

}  // namespace

MaskingTable::MaskingTable(const SlopeFrame& frame, const SlopePoints& points)
    : frame_(frame), excess_(kAzimuths, kElevations + 1) {
  for (const float m : points.mass)
    mass_ += static_cast<double>(m);
  // E(c) = ∫(c − s)₊ − mass·max(c, 0): 0 for c → −∞, −∫s for c → ∞. Along −e, s changes its sign.
  parallel_for(kAzimuths / 2, [&](std::int64_t k) {
    const Marginal marginal = project(points, 2 * std::numbers::pi * static_cast<double>(k) / kAzimuths);
    const double all = marginal.mass[kElevations], mean = marginal.moment[kElevations];
    for (int i = 0; i <= kElevations; ++i) {
      const bool ends = i == 0 || i == kElevations;
      const double c = ends ? 0 : cotangent(i);
      const double below = c * marginal.mass[i] - marginal.moment[i];  // ∫(c − s)₊
      // ∫(s − c)₊, which is (c' − s')₊ of the opposite direction at c' = −c
      const double above = (mean - marginal.moment[i]) - c * (all - marginal.mass[i]);
      const double positive = all * std::max(c, 0.), negative = all * std::max(-c, 0.);
      excess_(k, i) = i == 0 ? 0 : i == kElevations ? -mean : below - positive;
      excess_(k + kAzimuths / 2, kElevations - i) = i == kElevations ? 0 : i == 0 ? mean : above - negative;
    }
  });
}

double MaskingTable::visible_area(const Vec3& u) const {
  const double a = frame_.l11 * u.x() + frame_.l21 * u.y(), b = frame_.l22 * u.y(),
               z = u.z() - frame_.centre.x() * u.x() - frame_.centre.y() * u.y();
  const double across = std::sqrt(a * a + b * b), direct = mass_ * std::max(z, 0.);
  if (!(across > 0)) return direct;
  // x = c/(1 + |c|) without dividing by a small `across`.
  const double x = z / (across + std::abs(z));
  const double position = (x + 1) * (kElevations / 2);
  const int i = std::min(static_cast<int>(position), kElevations - 1);
  double turn = std::atan2(b, a) * (kAzimuths / (2 * std::numbers::pi));
  turn += turn < 0 ? kAzimuths : 0;
  const int j = std::min(static_cast<int>(turn), kAzimuths - 1), next = (j + 1) % kAzimuths;
  const double t = position - i, s = turn - j;
  const double excess = (1 - s) * ((1 - t) * excess_(j, i) + t * excess_(j, i + 1)) +
                        s * ((1 - t) * excess_(next, i) + t * excess_(next, i + 1));
  return std::max(0., across * excess + direct);
}

}  // namespace micro
