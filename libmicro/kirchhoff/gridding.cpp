#include "kirchhoff/gridding.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace micro {

GriddingKernel::GriddingKernel(int width, double oversampling, double pitch)
    : half_width_(width * pitch / 2), pitch_(pitch) {
  assert(width >= 2 && oversampling > 1 && pitch > 0);
  const double a = width / oversampling * (oversampling - 0.5);
  beta_ = std::numbers::pi * std::sqrt(std::max(a * a - 0.8, 0.1));
  peak_ = std::cyl_bessel_i(0.0, beta_);
}

double GriddingKernel::operator()(double x) const {
  const double t = x / half_width_;
  return std::abs(t) > 1 ? 0 : std::cyl_bessel_i(0.0, beta_ * std::sqrt(1 - t * t)) / peak_;
}

double GriddingKernel::derivative(double x) const {
  const double t = x / half_width_;
  if (std::abs(t) > 1) return 0;
  const double root = std::sqrt(1 - t * t);
  // I₁(βr)/r → β/2 for r → 0
  const double ratio = root > 1e-8 ? std::cyl_bessel_i(1.0, beta_ * root) / root : beta_ / 2;
  return -beta_ * t * ratio / peak_ / half_width_;
}

double GriddingKernel::spectrum(double q) const {
  const double s = beta_ * beta_ - q * q * half_width_ * half_width_;
  const double root = std::sqrt(std::abs(s));
  const double shape = root < 1e-6 ? 1 : s > 0 ? std::sinh(root) / root : std::sin(root) / root;
  return 2 * half_width_ * shape / peak_ / pitch_;
}

template <typename Real>
GatherTable<Real> make_gather(const GriddingKernel& kernel, double spacing, int offset, int step,
                              std::int64_t sources, std::int64_t begin, std::int64_t end) {
  assert(sources >= 1);
  const double stride = spacing * step, origin = spacing * offset, reach = kernel.half_width();
  GatherTable<Real> table;
  table.taps =
      static_cast<int>(std::min<double>(static_cast<double>(sources), std::floor(2 * reach / stride) + 1));
  for (std::int64_t m = begin; m < end; ++m) {
    const double x = static_cast<double>(m) * kernel.pitch();
    const auto first = static_cast<std::int64_t>(std::ceil((x - reach - origin) / stride));
    const std::int64_t start = std::clamp<std::int64_t>(first, 0, sources - table.taps);
    table.start.push_back(static_cast<std::int32_t>(start));
    for (int t = 0; t < table.taps; ++t) {
      const double distance = x - origin - static_cast<double>(start + t) * stride;
      table.value.push_back(static_cast<Real>(kernel(distance)));
      table.derivative.push_back(static_cast<Real>(kernel.derivative(distance)));
    }
  }
  return table;
}

template <typename Real>
ScatterTable<Real> make_scatter(const GriddingKernel& kernel, double spacing, std::int64_t sources,
                                std::int64_t begin, std::int64_t end) {
  const double reach = kernel.half_width();
  ScatterTable<Real> table;
  table.taps = static_cast<int>(
      std::min<double>(static_cast<double>(end - begin), std::floor(2 * reach / kernel.pitch()) + 1));
  for (std::int64_t l = 0; l < sources; ++l) {
    const double x = static_cast<double>(l) * spacing;
    const auto first = static_cast<std::int64_t>(std::ceil((x - reach) / kernel.pitch()));
    const std::int64_t start = std::clamp<std::int64_t>(first, begin, end - table.taps);
    table.start.push_back(static_cast<std::int32_t>(start - begin));
    for (int t = 0; t < table.taps; ++t) {
      const double distance = static_cast<double>(start + t) * kernel.pitch() - x;
      table.value.push_back(static_cast<Real>(kernel(distance)));
      table.derivative.push_back(static_cast<Real>(kernel.derivative(distance)));
    }
  }
  return table;
}

template GatherTable<float> make_gather(const GriddingKernel&, double, int, int, std::int64_t, std::int64_t,
                                        std::int64_t);
template GatherTable<double> make_gather(const GriddingKernel&, double, int, int, std::int64_t, std::int64_t,
                                         std::int64_t);
template ScatterTable<float> make_scatter(const GriddingKernel&, double, std::int64_t, std::int64_t,
                                          std::int64_t);
template ScatterTable<double> make_scatter(const GriddingKernel&, double, std::int64_t, std::int64_t,
                                           std::int64_t);

}  // namespace micro
