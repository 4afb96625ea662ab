#include "kirchhoff/kirchhoff.h"

#include <numbers>
#include <string>

#include "core/error.h"
#include "height/triangles.h"

namespace micro {

Vec3 wave_vector(const Vec3& h, double lambda_q) {
  if (!(lambda_q > 0 && std::isfinite(lambda_q)))
    throw InputError("the effective wavelength must be positive and finite, not " + std::to_string(lambda_q) +
                     " µm");
  return (4 * std::numbers::pi / lambda_q) * h;
}

double kirchhoff_density(std::complex<double> field, double projected_area) {
  return std::norm(field) / (4 * std::numbers::pi * std::numbers::pi * projected_area);
}

double kirchhoff_area(const HeightField& surface) {
  const double area = projected_area(surface);
  if (!(area > 0))
    throw InputError("not one triangle of the surface is there: D_K needs three neighbouring heights");
  return area;
}

}  // namespace micro
