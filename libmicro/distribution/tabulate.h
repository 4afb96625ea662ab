#pragma once

#include <cmath>

#include "core/parallel.h"
#include "distribution/disk_table.h"
#include "distribution/distribution.h"

namespace micro {

/// A model by its values at the nodes, 1/sr. Throws InputError as make_disk_table does.
template <Distribution Model>
DiskTable tabulate(const Model& model, const DiskGrid& grid) {
  DiskTable table = make_disk_table(grid);
  const auto fill = [&](std::int64_t begin, std::int64_t end) {
    for (Eigen::Index j = begin; j < end; ++j)
      for (Eigen::Index i = 0; i < grid.size; ++i)
        if (const double mz2 = grid.mz2(j, i); mz2 > 0)
          table.density(j, i) = model.D({grid.coordinate(i), grid.coordinate(j), std::sqrt(mz2)});
  };
  constexpr int kWorthThreads = 257;
  if (grid.size < kWorthThreads)
    fill(0, grid.size);
  else
    parallel_blocks(grid.size, 16, fill);
  return table;
}

}  // namespace micro
