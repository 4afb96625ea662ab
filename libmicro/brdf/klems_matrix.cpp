#include "brdf/klems_matrix.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "core/parallel.h"
#include "core/random.h"

namespace micro {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180;

/// A ring's first patch.
std::size_t first_patch(std::size_t ring) {
  std::size_t first = 0;
  for (std::size_t r = 0; r < ring; ++r)
    first += static_cast<std::size_t>(kKlemsRings[r].patches);
  return first;
}

std::size_t ring_of(std::size_t patch) {
  std::size_t ring = 0;
  while (ring + 1 < kKlemsRings.size() && patch >= first_patch(ring + 1))
    ++ring;
  return ring;
}

double sine2(double degrees) {
  const double sine = std::sin(degrees * kDegree);
  return sine * sine;
}

/// A direction of a patch, by cosθ dω.
Vec3 drawn_in(std::size_t patch, const std::array<double, 2>& xi) {
  const std::size_t ring = ring_of(patch);
  const KlemsRing& r = kKlemsRings[ring];
  const double squared = sine2(r.low) + xi[0] * (sine2(r.high) - sine2(r.low)), sine = std::sqrt(squared);
  const double phi = 2 * kPi * (static_cast<double>(patch - first_patch(ring)) + xi[1] - 0.5) / r.patches;
  return {sine * std::cos(phi), sine * std::sin(phi), std::sqrt(1 - squared)};
}

}  // namespace

std::size_t klems_patch(const Vec3& w) {
  const double theta = std::atan2(w.head<2>().norm(), w.z()) / kDegree;
  std::size_t ring = 0;
  while (ring + 1 < kKlemsRings.size() && theta >= kKlemsRings[ring].high)
    ++ring;
  const int patches = kKlemsRings[ring].patches;
  const double turns = std::atan2(w.y(), w.x()) / (2 * kPi) * patches;
  const int index = (static_cast<int>(std::lround(turns)) + patches) % patches;
  return first_patch(ring) + static_cast<std::size_t>(index);
}

double klems_projected_solid_angle(std::size_t patch) {
  const KlemsRing& r = kKlemsRings[ring_of(patch)];
  return kPi * (sine2(r.high) - sine2(r.low)) / r.patches;
}

KlemsMatrix klems_matrix(const AnyBrdf& model, const std::vector<double>& lambda_um,
                         const std::vector<double>& weights, std::uint64_t draws) {
  assert(lambda_um.size() == weights.size());
  constexpr std::uint64_t kSeed = 145;
  const double drawn_at = lambda_um[lambda_um.size() / 2];
  KlemsMatrix matrix{std::vector<double>(kKlemsPatches * kKlemsPatches), 0};
  std::vector<double> errors(kKlemsPatches);
  parallel_for(static_cast<std::int64_t>(kKlemsPatches), [&](std::int64_t n) {
    const auto column = static_cast<std::size_t>(n);
    const auto stream = static_cast<std::uint32_t>(2 * column);
    double sum = 0, squares = 0;
    for (std::uint64_t k = 0; k < draws; ++k) {
      const Vec3 gone = drawn_in(column, random_uniform(kSeed, stream, k));
      const auto xi = random_uniform(kSeed, stream + 1, k);
      const Vec3 wi(-gone.x(), -gone.y(), gone.z());
      const auto draw = model.sample(wi, drawn_at, {xi[0], xi[1]});
      if (!draw || !(draw->wo.z() > 0)) continue;
      double f = 0;
      for (std::size_t c = 0; c < lambda_um.size(); ++c)
        f += weights[c] * model.f(wi, draw->wo, lambda_um[c]);
      const double value = f * draw->wo.z() / draw->pdf;
      const std::size_t row = klems_patch(draw->wo);
      matrix.f[row * kKlemsPatches + column] +=
          value / (static_cast<double>(draws) * klems_projected_solid_angle(row));
      sum += value;
      squares += value * value;
    }
    const double count = static_cast<double>(draws), mean = sum / count;
    errors[column] = std::sqrt(std::max(0., squares / count - mean * mean) / count);
  });
  matrix.standard_error = *std::max_element(errors.begin(), errors.end());
  return matrix;
}

}  // namespace micro
