#include "distribution/disk_table.h"

#include <string>

#include "core/error.h"

namespace micro {

DiskTable make_disk_table(const DiskGrid& grid) {
  if (grid.size < 3 || grid.size % 2 == 0)
    throw InputError("the table's size must be odd and at least 3, not " + std::to_string(grid.size));
  if (!(grid.extent > 0 && grid.extent <= 1))
    throw InputError("the table's extent must lie in (0, 1], not " + std::to_string(grid.extent));
  return {grid, Grid<double>::Zero(grid.size, grid.size)};
}

double normalization(const DiskTable& table) {
  return table.density.sum() * table.grid.spacing() * table.grid.spacing();
}

}  // namespace micro
