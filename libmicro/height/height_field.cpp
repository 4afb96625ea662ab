#include "height/height_field.h"

#include "core/error.h"

namespace micro {

Eigen::Index missing_count(const HeightField& surface) {
  return surface.z.isNaN().count();
}

HeightField make_height_field(const Grid<double>& z, double dx, double dy) {
  if (!(dx > 0 && dy > 0 && std::isfinite(dx) && std::isfinite(dy)))
    throw InputError("the pitch must be positive and finite, not " + std::to_string(dx) + " × " +
                     std::to_string(dy) + " µm");
  // The first valid height goes first: a plain sum of 76 mm offsets would cost the digits of an 8 nm
  // roughness.
  double first = 0;
  for (const double value : z.reshaped<Eigen::RowMajor>())
    if (std::isfinite(value)) {
      first = value;
      break;
    }
  double sum = 0;
  Eigen::Index valid = 0;
  for (const double value : z.reshaped<Eigen::RowMajor>())
    if (std::isfinite(value)) {
      sum += value - first;
      ++valid;
    }
  HeightField surface;
  surface.dx = dx;
  surface.dy = dy;
  surface.mean = valid > 0 ? first + sum / static_cast<double>(valid) : 0;
  surface.z = z.unaryExpr([&](double value) {
    return std::isfinite(value) ? static_cast<float>(value - surface.mean) : kMissing;
  });
  return surface;
}

}  // namespace micro
