#include "kirchhoff/gridding.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace micro {

namespace {

/// I₀(x) and I₁(x)/x from y = x²/4 by their power series [NIST DLMF 10.25.2]: smooth at x = 0, all terms
/// positive.
struct BesselPair {
  double i0, i1_over_x;
};

BesselPair modified_bessel(double y) {
  BesselPair sum = {0, 0};
  double term = 1;  // y^k/k!²
  for (int k = 0; term > 1e-17 * sum.i0; ++k) {
    sum.i0 += term;
    sum.i1_over_x += term / (2 * (k + 1));
    term *= y / ((k + 1.0) * (k + 1.0));
  }
  return sum;
}

}  // namespace

GriddingKernel::GriddingKernel(int width, double oversampling, double pitch)
    : width_(width), half_width_(width * pitch / 2), pitch_(pitch) {
  assert(width >= 2 && oversampling > 1 && pitch > 0);
  const double a = width / oversampling * (oversampling - 0.5);
  beta_ = std::numbers::pi * std::sqrt(std::max(a * a - 0.8, 0.1));
  peak_ = modified_bessel(beta_ * beta_ / 4).i0;
}

GriddingKernel::Value GriddingKernel::operator()(double x) const {
  const double t = x / half_width_;
  if (std::abs(t) > 1) return {0, 0};
  const BesselPair bessel = modified_bessel(beta_ * beta_ * (1 - t * t) / 4);
  return {bessel.i0 / peak_, -beta_ * beta_ * t * bessel.i1_over_x / peak_ / half_width_};
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
      const GriddingKernel::Value value = kernel(distance);
      table.value.push_back(static_cast<Real>(value.k));
      table.derivative.push_back(static_cast<Real>(value.slope));
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
      const GriddingKernel::Value value = kernel(distance);
      table.value.push_back(static_cast<Real>(value.k));
      table.derivative.push_back(static_cast<Real>(value.slope));
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

GriddingKernelTable::GriddingKernelTable(const GriddingKernel& kernel)
    : half_width_(kernel.half_width()), per_length_(0) {
  constexpr int kEntries = 1024;
  per_length_ = kEntries / half_width_;
  for (int n = 0; n <= kEntries; ++n) {
    const GriddingKernel::Value value = kernel(half_width_ * n / kEntries);
    entries_.push_back({value.k, value.slope / per_length_});
  }
}

GriddingKernel::Value GriddingKernelTable::operator()(double x) const {
  const double position = std::abs(x) * per_length_;
  const auto n = static_cast<std::size_t>(position);
  if (!(position < static_cast<double>(entries_.size() - 1))) return {0, 0};
  const double t = position - static_cast<double>(n), s = 1 - t;
  const Entry &a = entries_[n], &b = entries_[n + 1];
  const double slope = 6 * s * t * (b.k - a.k) + s * (s - 2 * t) * a.slope + t * (t - 2 * s) * b.slope;
  return {s * s * ((1 + 2 * t) * a.k + t * a.slope) + t * t * ((3 - 2 * t) * b.k - s * b.slope),
          (x < 0 ? -slope : slope) * per_length_};
}

}  // namespace micro
