#include "ndf/truncation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "ndf/gaussian_passes.h"

namespace micro {
namespace {

/// Σ g·u^k, k = 0, 1, 2, along one axis: beyond the window on both sides, and over the whole axis; and the
/// least Σ g and Σ g·(x − x̄)² of any window that the border leaves.
struct AxisSums {
  std::array<double, 3> tail{}, all{};
  double least_weight = std::numeric_limits<double>::infinity(), least_variance = least_weight;
};

AxisSums axis_sums(std::size_t points, double pitch, double sigma) {
  const GaussianTaps taps(pitch, sigma, points - 1);
  const std::size_t radius = taps.radius();
  const double* g = taps.moment(0);
  // Windows that begin `left` points before their centre; the border leaves at least one side whole, or the
  // whole axis. Sums grow with the window, so its two shapes with the least points decide.
  AxisSums sums;
  double mean = 0;
  for (const std::size_t left : {std::size_t{0}, std::min(radius, (points - 1) / 2)}) {
    const std::size_t right = std::min(radius, points - 1 - left);
    double m0 = 0, m1 = 0, m2 = 0;
    for (std::size_t t = radius - left; t <= radius + right; ++t) {
      m0 += g[t];
      m1 += taps.moment(1)[t];
      m2 += taps.moment(2)[t];
    }
    mean = std::max(mean, std::abs(m1 / m0));
    sums.least_weight = std::min(sums.least_weight, m0);
    sums.least_variance = std::min(sums.least_variance, m2 - m1 * m1 / m0);
  }
  const auto add = [&](std::array<double, 3>& to, std::size_t t, double sides) {
    const double x = static_cast<double>(t) * pitch / sigma, w = sides * std::exp(-x * x / 2), u = x + mean;
    to[0] += w;
    to[1] += w * u;
    to[2] += w * u * u;
  };
  for (std::size_t t = 0; t <= radius; ++t)
    add(sums.all, t, t == 0 ? 1 : 2);
  constexpr double kNothing = 40;  // in σ: exp(−40²/2) is 0 in double
  const double end = kNothing * sigma / pitch;
  for (std::size_t t = radius + 1; t < points && static_cast<double>(t) <= end; ++t)
    add(sums.tail, t, 2);
  for (std::size_t k = 0; k < 3; ++k)
    sums.all[k] += sums.tail[k];
  return sums;
}

/// Largest |z|, in µm.
double height_bound(const HeightField& surface) {
  float bound = 0;
  for (const float z : surface.z.reshaped<Eigen::RowMajor>())
    if (!is_missing(z)) bound = std::max(bound, std::abs(z));
  return static_cast<double>(bound);
}

/// The bound along x, or with everything exchanged along y.
double bound_along(const AxisSums& x, const AxisSums& y, double height, double sigma, double zx, double zy) {
  const auto outside = [&](std::size_t a, std::size_t b) {
    return x.tail[a] * y.all[b] + x.all[a] * y.tail[b];
  };
  const double sum = 2 * height * outside(1, 0) + sigma * zx * outside(2, 0) + sigma * zy * outside(1, 1);
  return sum == 0 ? 0 : sum / (sigma * x.least_variance * y.least_weight);
}

}  // namespace

double slope_truncation_bound(const HeightField& surface, double sigma, const SlopeBounds& slopes) {
  if (surface.z.size() == 0) return 0;
  const AxisSums x = axis_sums(static_cast<std::size_t>(surface.cols()), surface.dx, sigma);
  const AxisSums y = axis_sums(static_cast<std::size_t>(surface.rows()), surface.dy, sigma);
  const double height = height_bound(surface);
  return std::max(bound_along(x, y, height, sigma, slopes.zx, slopes.zy),
                  bound_along(y, x, height, sigma, slopes.zy, slopes.zx));
}

}  // namespace micro
