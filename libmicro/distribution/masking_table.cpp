#include "distribution/masking_table.h"

#include <algorithm>
#include <array>
#include <numbers>

#include "core/parallel.h"

namespace micro {
namespace {

constexpr int kAzimuths = 128;    // of the whole turn; opposite ones share a projection
constexpr int kElevations = 128;  // steps of x = c/(1 + |c|) from −1 to 0
constexpr int kNodes = kElevations + 1;

/// c of the node k of x, k > 0.
double cotangent(int k) {
  return static_cast<double>(k - kElevations) / k;
}

/// Mass and first moment of the slopes s along one direction, in bins of x from −1 to 1.
struct Marginal {
  std::array<double, 2 * kElevations> mass{}, moment{};

  void add(double s, double m) {
    const double x = s / (1 + std::abs(s));
    const auto bin =
        static_cast<std::size_t>(std::clamp(static_cast<int>((x + 1) * kElevations), 0, 2 * kElevations - 1));
    mass[bin] += m;
    moment[bin] += m * s;
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
  return marginal;
}

/// Weights of the values before a cell, at its ends and behind it, for the cubic through them.
std::array<double, 4> cubic_weights(double t) {
  return {-t * (t - 1) * (t - 2) / 6, (t + 1) * (t - 1) * (t - 2) / 2, -(t + 1) * t * (t - 2) / 2,
          (t + 1) * t * (t - 1) / 6};
}

}  // namespace

MaskingTable::MaskingTable(const SlopeFrame& frame, const SlopePoints& points)
    : frame_(frame), flank_(static_cast<std::size_t>(kAzimuths) * kNodes) {
  for (std::size_t k = 0; k < points.mass.size(); ++k) {
    const double m = points.mass[k];
    mass_ += m;
    mean_ += m * Vec2(points.v1[k], points.v2[k]);
  }
  parallel_for(kAzimuths / 2, [&](std::int64_t azimuth) {
    const Marginal marginal =
        project(points, 2 * std::numbers::pi * static_cast<double>(azimuth) / kAzimuths);
    Node* below = &flank_[static_cast<std::size_t>(azimuth) * kNodes];
    Node* above = &flank_[static_cast<std::size_t>(azimuth + kAzimuths / 2) * kNodes];
    double mass_below = 0, moment_below = 0, mass_above = 0, moment_above = 0;
    for (int k = 1; k < kNodes; ++k) {
      const auto bin = static_cast<std::size_t>(k - 1), mirrored = marginal.mass.size() - 1 - bin;
      mass_below += marginal.mass[bin];
      moment_below += marginal.moment[bin];
      mass_above += marginal.mass[mirrored];
      moment_above += marginal.moment[mirrored];
      const double c = cotangent(k), dc = kElevations / static_cast<double>(k) / k;  // ∂c/∂x·(1/kElevations)
      below[k] = {c * mass_below - moment_below, dc * mass_below};
      above[k] = {c * mass_above + moment_above, dc * mass_above};
    }
    for (Node* flank : {below, above})
      flank[0] = {0, flank[1].value};
  });
}

double MaskingTable::visible_area(const Vec3& u) const {
  const double a = frame_.l11 * u.x() + frame_.l21 * u.y(), b = frame_.l22 * u.y(),
               z = u.z() - frame_.centre.x() * u.x() - frame_.centre.y() * u.y();
  const double across = std::sqrt(a * a + b * b);
  const double direct = z > 0 ? mass_ * z - mean_.x() * a - mean_.y() * b : 0;
  if (!(across > 0)) return direct;
  // 1 − |x| = across/(across + |z|) without dividing by a small `across`.
  const double position = kElevations * (across / (across + std::abs(z)));
  const int i = std::min(static_cast<int>(position), kElevations - 1);
  const double t = position - i, r = 1 - t;
  double turn = std::atan2(b, a) * (kAzimuths / (2 * std::numbers::pi)) + kAzimuths;
  if (z > 0) turn += kAzimuths / 2.;
  const double whole = std::floor(turn);
  const auto j = static_cast<std::size_t>(whole) + kAzimuths - 1;
  const std::array<double, 4> weights = cubic_weights(turn - whole);
  double flank = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const Node* node = &flank_[(j + k) % kAzimuths * kNodes + static_cast<std::size_t>(i)];
    // The cubic of values and derivatives at both ends.
    flank += weights[k] * (r * r * ((1 + 2 * t) * node[0].value + t * node[0].step) +
                           t * t * ((1 + 2 * r) * node[1].value - r * node[1].step));
  }
  return std::max(0., across * std::max(0., flank) + direct);
}

}  // namespace micro
