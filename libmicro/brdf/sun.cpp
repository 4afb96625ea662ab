#include "brdf/sun.h"

#include "core/error.h"

namespace micro {

Beckmann normals_of_smoothness(double s) {
  if (!(s > 0 && std::isfinite(s)))
    throw InputError("a surface's smoothness tau/rms must be positive and finite");
  return gaussian_surface_normals({1, s, s});
}

}  // namespace micro
