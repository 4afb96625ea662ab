#include "kirchhoff/point_scatter.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/parallel.h"

namespace micro {
namespace {

/// The first of `width` grid points within reach of a place, from the axis' first.
std::int32_t first_point(const ScatterAxis& axis, double place, int width) {
  const auto first = static_cast<std::int64_t>(std::floor(place / axis.kernel.pitch() - width / 2.0)) + 1;
  return static_cast<std::int32_t>(std::clamp(first, axis.begin, axis.end - width) - axis.begin);
}

template <typename Real>
void fill_taps(const ScatterAxis& axis, const GriddingKernelTable& kernel, double place, std::int32_t first,
               std::span<Real> taps) {
  for (std::size_t t = 0; t < taps.size(); ++t) {
    const std::int64_t m = first + static_cast<std::int64_t>(t);
    const double distance = static_cast<double>(axis.begin + m) * axis.kernel.pitch() - place;
    const double factor = axis.factor.empty() ? 1 : axis.factor[static_cast<std::size_t>(m)];
    const GriddingKernel::Value value = kernel(distance);
    taps[t] = static_cast<Real>(factor * (axis.by == SpreadBy::Kernel ? value.k : value.slope));
  }
}

}  // namespace

template <typename Real>
PointScatter<Real> make_point_scatter(std::span<const SurfacePoint> points, const ScatterAxis& x,
                                      const ScatterAxis& y) {
  const std::size_t count = points.size();
  PointScatter<Real> scatter;
  scatter.taps = x.kernel.width();
  if (count == 0) return scatter;
  std::vector<std::int32_t> row(count);
  std::transform(points.begin(), points.end(), row.begin(),
                 [&](const SurfacePoint& point) { return first_point(y, point.y, scatter.taps); });
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return row[a] < row[b]; });
  const auto taps = static_cast<std::size_t>(scatter.taps);
  scatter.col.resize(count);
  scatter.row.resize(count);
  scatter.z.resize(count);
  scatter.weight.resize(count);
  scatter.x.resize(count * taps);
  scatter.y.resize(count * taps);
  const GriddingKernelTable kernel_x(x.kernel), kernel_y(y.kernel);
  constexpr std::int64_t kBlock = 4096;
  parallel_blocks(static_cast<std::int64_t>(count), kBlock, [&](std::int64_t begin, std::int64_t end) {
    for (auto n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end); ++n) {
      const SurfacePoint& point = points[order[n]];
      scatter.col[n] = first_point(x, point.x, scatter.taps);
      scatter.row[n] = row[order[n]];
      scatter.z[n] = point.z;
      scatter.weight[n] = point.weight;
      fill_taps(x, kernel_x, point.x, scatter.col[n], std::span(&scatter.x[n * taps], taps));
      fill_taps(y, kernel_y, point.y, scatter.row[n], std::span(&scatter.y[n * taps], taps));
    }
  });
  return scatter;
}

template PointScatter<float> make_point_scatter(std::span<const SurfacePoint>, const ScatterAxis&,
                                                const ScatterAxis&);
template PointScatter<double> make_point_scatter(std::span<const SurfacePoint>, const ScatterAxis&,
                                                 const ScatterAxis&);

}  // namespace micro
