#include "height/height_field.h"

#include "core/error.h"

namespace micro {

Eigen::Index missing_count(const HeightField& surface) {
  return surface.z.isNaN().count();
}

namespace detail {

void check_pitch(double dx, double dy) {
  if (!(dx > 0 && dy > 0 && std::isfinite(dx) && std::isfinite(dy)))
    throw InputError("the pitch must be positive and finite, not " + std::to_string(dx) + " × " +
                     std::to_string(dy) + " µm");
}

void refuse_height_range() {
  throw InputError("the heights are too far apart for single precision");
}

}  // namespace detail

HeightField make_height_field(const Grid<double>& z, double dx, double dy) {
  return sample_height_field(z.rows(), z.cols(), dx, dy, [&](Eigen::Index k) { return z.data()[k]; });
}

}  // namespace micro
