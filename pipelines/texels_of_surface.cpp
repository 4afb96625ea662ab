#include "pipelines/texels_of_surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "core/error.h"
#include "core/parallel.h"
#include "fit/slope_fit.h"
#include "ndf/gaussian_passes.h"
#include "ndf/local_planes.h"

namespace micro {
namespace {

std::vector<float> own_table(const SlopeBlock& zx, const SlopeBlock& zy, const SlopeFrame& frame, int size,
                             std::int64_t normals) {
  std::vector<float> table(static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
  const double spacing = size > 1 ? 2 * kNdfReach / (size - 1) : 2 * kNdfReach;
  const double share = 1 / (static_cast<double>(normals) * spacing * spacing);
  for (Eigen::Index j = 0; j < zx.rows(); ++j)
    for (Eigen::Index i = 0; i < zx.cols(); ++i) {
      if (std::isnan(zx(j, i))) continue;
      const Vec2 v = (frame.whiten({zx(j, i), zy(j, i)}).array() + kNdfReach) / spacing;
      if (!((v.array() > -0.5).all() && (v.array() < size - 0.5).all())) continue;
      const auto node = static_cast<std::size_t>(std::lrint(v.y()) * size + std::lrint(v.x()));
      table[node] += static_cast<float>(share);
    }
  return table;
}

Texel texel_of(const SlopeBlock& zx, const SlopeBlock& zy, const TexelCut& cut, double point_area) {
  Texel texel;
  for (Eigen::Index j = 0; j < zx.rows(); ++j)
    for (Eigen::Index i = 0; i < zx.cols(); ++i) {
      if (std::isnan(zx(j, i))) continue;
      ++texel.normals;
      texel.mean_slope += Vec2(zx(j, i), zy(j, i));
    }
  const auto n = static_cast<double>(texel.normals);
  if (texel.normals > 0) texel.mean_slope /= n;
  texel.independent = n * point_area / (4 * std::numbers::pi * cut.sigma * cut.sigma);
  texel.fit = fit_slopes(zx, zy);
  if (cut.ndf_size > 0 && texel.normals > 0)
    texel.slopes = own_table(zx, zy, texel.fit.frame, cut.ndf_size, texel.normals);
  return texel;
}

/// A window that reaches over the whole surface gives every point one and the same plane.
void require_window(const HeightField& surface, double sigma) {
  const double width = static_cast<double>(surface.cols()) * surface.dx,
               height = static_cast<double>(surface.rows()) * surface.dy;
  if (sigma <= std::min(width, height)) return;
  std::ostringstream reason;
  reason << "the normals' window (--sigma " << sigma << "um) is longer than the scan, which is " << width
         << " x " << height << " um";
  throw InputError(reason.str());
}

}  // namespace

SurfaceTexels texels_of_surface(const HeightField& surface, const TexelCut& cut) {
  constexpr Eigen::Index kBandPoints = 1 << 24;  // 256 MB of slopes: less of them is computed twice
  const Eigen::Index rows = cut.rows > 0 ? cut.rows : surface.rows(),
                     cols = cut.cols > 0 ? cut.cols : surface.cols();
  require_window(surface, cut.sigma);
  SurfaceTexels result;
  result.rows = surface.rows() / rows;
  result.cols = surface.cols() / cols;
  if (result.rows == 0 || result.cols == 0) throw InputError("it is smaller than a texel");
  result.texels.resize(static_cast<std::size_t>(result.rows * result.cols));
  const auto reach = static_cast<Eigen::Index>(std::ceil(GaussianTaps::kReach * cut.sigma / surface.dy));
  const Eigen::Index band = std::max<Eigen::Index>(1, kBandPoints / (rows * surface.cols()));
  for (Eigen::Index first = 0; first < result.rows; first += band) {
    const Eigen::Index count = std::min(band, result.rows - first);
    const Eigen::Index begin = std::max<Eigen::Index>(0, first * rows - reach),
                       end = std::min(surface.rows(), (first + count) * rows + reach);
    const bool whole = begin == 0 && end == surface.rows();
    const SlopeField slopes =
        whole
            ? local_planes(surface, cut.sigma)
            : local_planes({surface.z.middleRows(begin, end - begin), surface.dx, surface.dy, 0}, cut.sigma);
    parallel_for(count * result.cols, [&](std::int64_t k) {
      const Eigen::Index row = first + k / result.cols, col = k % result.cols;
      const auto block = [&](const Grid<double>& slope) {
        return slope.block(row * rows - begin, col * cols, rows, cols);
      };
      result.texels[static_cast<std::size_t>(row * result.cols + col)] =
          texel_of(block(slopes.zx), block(slopes.zy), cut, surface.dx * surface.dy);
    });
  }
  return result;
}

}  // namespace micro
