#include "height/triangles.h"

namespace micro {

std::int64_t triangle_count(const HeightField& surface) {
  std::int64_t count = 0;
  for (Eigen::Index j = 0; j + 1 < surface.rows(); ++j)
    for_each_triangle(surface, j, [&](const Triangle&) { ++count; });
  return count;
}

double projected_area(const HeightField& surface) {
  return static_cast<double>(triangle_count(surface)) * surface.dx * surface.dy / 2;
}

}  // namespace micro
