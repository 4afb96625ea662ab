#include "testing/exact_table.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "height/triangles.h"
#include "kirchhoff/exact.h"

namespace micro::testing {

DiskTable exact_table(const HeightField& surface, const DiskGrid& grid, double lambda_q) {
  DiskTable table = make_disk_table(grid);
  std::vector<Vec3> q;
  for (Eigen::Index j = 0; j < grid.size; ++j)
    for (Eigen::Index i = 0; i < grid.size; ++i)
      if (grid.mz2(j, i) > 0)
        q.push_back(
            wave_vector(Vec3(grid.coordinate(i), grid.coordinate(j), std::sqrt(grid.mz2(j, i))), lambda_q));
  const auto fields = exact_field(surface, q);
  const double area = projected_area(surface);
  auto field = fields.begin();
  for (Eigen::Index j = 0; j < grid.size; ++j)
    for (Eigen::Index i = 0; i < grid.size; ++i)
      if (grid.mz2(j, i) > 0) table.density(j, i) = kirchhoff_density(*field++, area);
  return table;
}

TableError table_error(const Grid<double>& got, const DiskTable& want, double core) {
  double difference = 0, total = 0, outer_difference = 0, outer_total = 0;
  std::vector<double> relative;
  const double peak = want.density.maxCoeff();
  for (Eigen::Index j = 0; j < want.grid.size; ++j)
    for (Eigen::Index i = 0; i < want.grid.size; ++i) {
      const double w = want.density(j, i), d = got(j, i) - w;
      difference += d * d;
      total += w * w;
      if (std::hypot(want.grid.coordinate(i), want.grid.coordinate(j)) > core) {
        outer_difference += d * d;
        outer_total += w * w;
      }
      if (w >= 1e-8 * peak && w > 0) relative.push_back(std::abs(d) / w);
    }
  const auto middle = relative.begin() + static_cast<std::ptrdiff_t>(relative.size() / 2);
  std::nth_element(relative.begin(), middle, relative.end());
  return {std::sqrt(difference / total), outer_total > 0 ? std::sqrt(outer_difference / outer_total) : 0,
          *middle};
}

}  // namespace micro::testing
