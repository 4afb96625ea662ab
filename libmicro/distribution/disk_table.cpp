#include "distribution/disk_table.h"

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <string>
#include <vector>

#include "core/error.h"

namespace micro {

DiskTable make_disk_table(const DiskGrid& grid) {
  if (grid.size < 3 || grid.size % 2 == 0)
    throw InputError("the table's size must be odd and at least 3, not " + std::to_string(grid.size));
  if (!(grid.extent > 0 && grid.extent <= 1))
    throw InputError("the table's extent must lie in (0, 1], not " + std::to_string(grid.extent));
  return {grid, Grid<double>::Zero(grid.size, grid.size)};
}

std::int64_t disk_nodes(const DiskGrid& grid) {
  const auto c = static_cast<Eigen::Index>(grid.centre());
  std::int64_t nodes = 0;
  Eigen::Index reach =
      c;  // columns c − reach … c + reach of a row are on the disk; it shrinks towards the rim
  for (Eigen::Index j = c; j < grid.size; ++j) {
    while (reach >= 0 && !(grid.mz2(j, c + reach) > 0))
      --reach;
    nodes += (j == c ? 1 : 2) * (2 * reach + 1) * (reach >= 0 ? 1 : 0);
  }
  return nodes;
}

double normalization(const DiskTable& table) {
  return table.density.sum() * table.grid.spacing() * table.grid.spacing();
}

double extent_holding(const DiskTable& table, double fraction) {
  const auto c = static_cast<Eigen::Index>(table.grid.centre());
  std::vector<double> rings(static_cast<std::size_t>(c) + 1, 0.);
  for (Eigen::Index j = 0; j < table.grid.size; ++j)
    for (Eigen::Index i = 0; i < table.grid.size; ++i)
      rings[static_cast<std::size_t>(std::max(std::abs(j - c), std::abs(i - c)))] += table.density(j, i);
  const double outside = (1 - fraction) * std::accumulate(rings.begin(), rings.end(), 0.);
  double beyond = 0;
  Eigen::Index ring = c;
  while (ring > 0 && beyond + rings[static_cast<std::size_t>(ring)] <= outside)
    beyond += rings[static_cast<std::size_t>(ring--)];
  return std::min(table.grid.extent, (static_cast<double>(ring) + 0.5) * table.grid.spacing());
}

}  // namespace micro
