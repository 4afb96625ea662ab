#include "ndf/normal_counts.h"

#include <cmath>

#include "height/triangles.h"

namespace micro {
namespace {

/// Puts normals into bins, one at a time.
class Binning {
 public:
  explicit Binning(const DiskGrid& grid)
      : scale_(1 / grid.spacing()), centre_(static_cast<int>(grid.centre())) {
    counts_.grid = grid;
    counts_.counts.assign(static_cast<std::size_t>(grid.size) * static_cast<std::size_t>(grid.size), 0);
  }

  /// Counts the normal (−zx, −zy, 1)/norm. A bin belongs to the node nearest to m_xy, except that a normal so
  /// steep that this node is off the disk goes to the next one towards the centre.
  void add(double zx, double zy) {
    const double inverse_norm = 1 / std::sqrt(1 + zx * zx + zy * zy);
    const double x = -zx * inverse_norm * scale_, y = -zy * inverse_norm * scale_;
    int i = static_cast<int>(std::lrint(x)), j = static_cast<int>(std::lrint(y));
    ++counts_.total;
    if (std::abs(i) > centre_ || std::abs(j) > centre_) {
      ++counts_.outside;
      return;
    }
    if (static_cast<double>(i * i + j * j) >= scale_ * scale_) {
      i = static_cast<int>(x);
      j = static_cast<int>(y);
    }
    ++counts_.counts[static_cast<std::size_t>(j + centre_) * static_cast<std::size_t>(counts_.grid.size) +
                     static_cast<std::size_t>(i + centre_)];
  }

  NormalCounts take() { return std::move(counts_); }

 private:
  NormalCounts counts_;
  double scale_;
  int centre_;
};

}  // namespace

NormalCounts naive_counts(const HeightField& surface, const DiskGrid& grid) {
  Binning binning(grid);
  for (Eigen::Index j = 0; j + 1 < surface.rows(); ++j)
    for_each_triangle(surface, j, [&](const Triangle& triangle) { binning.add(triangle.zx, triangle.zy); });
  return binning.take();
}

NormalCounts filtered_counts(const SlopeField& slopes, const DiskGrid& grid) {
  Binning binning(grid);
  const double* zx = slopes.zx.data();
  const double* zy = slopes.zy.data();
  for (Eigen::Index k = 0; k < slopes.zx.size(); ++k)
    if (!std::isnan(zx[k])) binning.add(zx[k], zy[k]);
  return binning.take();
}

DiskTable density(const NormalCounts& counts) {
  DiskTable table = make_disk_table(counts.grid);
  if (counts.total == 0) return table;
  const double spacing = counts.grid.spacing();
  const double unit = 1 / (static_cast<double>(counts.total) * spacing * spacing);
  for (Eigen::Index k = 0; k < table.density.size(); ++k)
    table.density.data()[k] = unit * counts.counts[static_cast<std::size_t>(k)];
  return table;
}

}  // namespace micro
