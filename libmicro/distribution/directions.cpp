#include "distribution/directions.h"

#include <cmath>
#include <numbers>
#include <string>

#include "core/error.h"

namespace micro {

std::vector<Vec3> spread_directions(int n, double extent) {
  if (n < 1) throw InputError("the number of directions must be at least 1, not " + std::to_string(n));
  if (!(extent > 0 && extent <= 1))
    throw InputError("the extent must lie in (0, 1], not " + std::to_string(extent));
  const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
  std::vector<Vec3> h;
  for (int k = 0; k < n; ++k) {
    const double r2 = extent * extent * (k + 0.5) / n, angle = golden_angle * k;
    h.emplace_back(std::sqrt(r2) * std::cos(angle), std::sqrt(r2) * std::sin(angle), std::sqrt(1 - r2));
  }
  return h;
}

}  // namespace micro
