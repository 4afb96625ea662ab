// A project that knows microbrdf only as an installed package.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>

#include "core/error.h"
#include "core/parallel.h"
#include "distribution/disk_table.h"
#include "height/height_field.h"
#include "height/triangles.h"

namespace {

/// A_perp of a 3 × 4 plate with one missing corner point, µm²: 12 triangles, less the two that hold the
/// corner.
double plate_area() {
  micro::Grid<double> z = micro::Grid<double>::Zero(3, 4);
  z(0, 0) = micro::kMissing;
  return micro::projected_area(micro::make_height_field(z, 0.5, 2));
}

/// ∫D m_z dω of D = 1/π, the distribution whose projection is uniform over the disk.
double uniform_normalization() {
  micro::DiskTable table = micro::make_disk_table({.size = 257, .extent = 1});
  micro::parallel_for(table.grid.size, [&](std::int64_t j) {
    for (Eigen::Index i = 0; i < table.grid.size; ++i)
      if (table.grid.mz2(j, i) > 0) table.density(j, i) = std::numbers::inv_pi;
  });
  return micro::normalization(table);
}

bool refuses_even_size() {
  try {
    micro::make_disk_table({.size = 256, .extent = 1});
  } catch (const micro::InputError&) {
    return true;
  }
  return false;
}

}  // namespace

int main() {
  const double area = plate_area();
  const double norm = uniform_normalization();
  std::printf("A_perp = %g, normalization = %g\n", area, norm);
  // Nodes counted on the rim make the sum off by less than a ring half a spacing wide.
  const bool right = area == 5 && std::abs(norm - 1) < 1.0 / 128 && refuses_even_size();
  return right ? 0 : 1;
}
