#include "brdf/coat.h"

#include <cmath>

#include "core/error.h"

namespace micro {

Fresnel under(const Fresnel& fresnel, double n) {
  Fresnel::Kind kind = fresnel.kind();
  if (std::holds_alternative<Schlick>(kind))
    throw InputError("Schlick's approximation has no optical constants to set under a coat");
  if (auto* index = std::get_if<std::complex<double>>(&kind)) *index /= n;
  if (auto* constants = std::get_if<OpticalConstants>(&kind))
    for (auto* values : {&constants->eta, &constants->kappa})
      for (double& value : *values)
        value /= n;
  return Fresnel(std::move(kind));
}

namespace detail {

void check_coat(const Coat& coat) {
  if (!(coat.n >= 1 && std::isfinite(coat.n))) throw InputError("a coat's index is 1 or more");
}

// n²z'² = z² + n² − 1 on unit vectors: nothing cancels at grazing angles, n = 1 changes nothing.
Vec3 refracted(const Vec3& w, double n) {
  return Vec3(w.x(), w.y(), std::sqrt(w.z() * w.z() + (n - 1) * (n + 1))) / n;
}

std::optional<Vec3> leaving(const Vec3& inside, double n) {
  const double z2 = n * n * inside.z() * inside.z() - (n - 1) * (n + 1);
  if (!(z2 > 0)) return std::nullopt;
  return Vec3(n * inside.x(), n * inside.y(), std::sqrt(z2));
}

}  // namespace detail
}  // namespace micro
