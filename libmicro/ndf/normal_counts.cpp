#include "ndf/normal_counts.h"

#include <algorithm>
#include <cmath>

#include "height/triangles.h"

namespace micro {
namespace {

/// Puts normals into bins, one at a time. Few of them are written down and sorted; many are counted in a
/// table, whose every node is then passed over.
class Binning {
 public:
  /// `most`: how many normals there may be.
  Binning(const DiskGrid& grid, Eigen::Index most)
      : scale_(1 / grid.spacing()), centre_(static_cast<int>(grid.centre())) {
    constexpr std::size_t kPassesOfSorting = 64;  // takes as long as so many nodes for each normal
    const auto nodes = static_cast<std::size_t>(grid.size) * static_cast<std::size_t>(grid.size);
    counts_.grid = grid;
    if (static_cast<std::size_t>(most) < nodes / kPassesOfSorting)
      few_.reserve(static_cast<std::size_t>(most));
    else
      table_.assign(nodes, 0);
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
    const std::int32_t node = (j + centre_) * counts_.grid.size + i + centre_;
    if (table_.empty())
      few_.push_back(node);
    else
      ++table_[static_cast<std::size_t>(node)];
  }

  NormalCounts take() {
    std::sort(few_.begin(), few_.end());
    for (std::size_t k = 0, next = 0; k < few_.size(); k = next) {
      while (next < few_.size() && few_[next] == few_[k])
        ++next;
      put(few_[k], static_cast<std::uint32_t>(next - k));
    }
    for (std::size_t k = 0; k < table_.size(); ++k)
      if (table_[k] > 0) put(static_cast<std::int32_t>(k), table_[k]);
    return std::move(counts_);
  }

 private:
  void put(std::int32_t node, std::uint32_t count) {
    counts_.nodes.push_back(node);
    counts_.counts.push_back(count);
  }

  NormalCounts counts_;
  std::vector<std::int32_t> few_;     // the node of each normal
  std::vector<std::uint32_t> table_;  // [size·size]; empty while few_ serves
  double scale_;
  int centre_;
};

}  // namespace

NormalCounts naive_counts(const HeightField& surface, const DiskGrid& grid) {
  Binning binning(grid, 2 * surface.z.size());
  for (Eigen::Index j = 0; j + 1 < surface.rows(); ++j)
    for_each_triangle(surface, j, [&](const Triangle& triangle) { binning.add(triangle.zx, triangle.zy); });
  return binning.take();
}

NormalCounts filtered_counts(const SlopeField& slopes, const DiskGrid& grid) {
  Binning binning(grid, slopes.zx.size());
  const double* zx = slopes.zx.data();
  const double* zy = slopes.zy.data();
  for (Eigen::Index k = 0; k < slopes.zx.size(); ++k)
    if (!std::isnan(zx[k])) binning.add(zx[k], zy[k]);
  return binning.take();
}

SparseTable sparse_density(const NormalCounts& counts) {
  SparseTable table{counts.grid, counts.nodes, {}};
  const double spacing = counts.grid.spacing();
  const double unit = 1 / (static_cast<double>(counts.total) * spacing * spacing);
  table.density.reserve(counts.counts.size());
  for (const std::uint32_t count : counts.counts)
    table.density.push_back(unit * count);
  return table;
}

DiskTable density(const NormalCounts& counts) {
  return dense(sparse_density(counts));
}

}  // namespace micro
