#include "height/synthetic_grid.h"

#include <string>

#include "core/error.h"
#include "core/parallel.h"

namespace micro {

void check(const SyntheticGrid& grid) {
  if (grid.rows < 1 || grid.cols < 1)
    throw InputError("a surface needs at least one row and one column, not " + std::to_string(grid.rows) +
                     " × " + std::to_string(grid.cols));
  // Row and column numbers enter random counters and triangles as 32-bit integers.
  constexpr Eigen::Index kMost = 1 << 24;
  if (grid.rows > kMost || grid.cols > kMost)
    throw InputError("a surface has at most 16777216 rows and as many columns");
  if (!(grid.dx > 0 && grid.dy > 0 && std::isfinite(grid.width()) && std::isfinite(grid.height())))
    throw InputError("the pitch must be positive and finite");
}

HeightField sample_heights(const SyntheticGrid& grid,
                           const std::function<double(Eigen::Index, Eigen::Index)>& z) {
  check(grid);
  Grid<double> heights(grid.rows, grid.cols);
  parallel_for(grid.rows, [&](Eigen::Index j) {
    for (Eigen::Index i = 0; i < grid.cols; ++i)
      heights(j, i) = z(j, i);
  });
  return make_height_field(heights, grid.dx, grid.dy);
}

}  // namespace micro
