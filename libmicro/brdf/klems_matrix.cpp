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

constexpr std::uint64_t kSeed = 145, kShifts = 16;

/// Point k of the lattice of multiples of (1/g, 1/g², 1/g³, 1/g⁴), g⁵ = g + 1, which fills the hypercube
/// evenly whatever the number of points [Roberts18], moved by a shift of the patch's own.
std::array<double, 4> lattice_point(std::uint64_t k, std::size_t patch, std::uint64_t shift) {
  constexpr std::array<std::uint64_t, 4> kSteps = {0xDB4F0B9175AE2165ull, 0xBBE0563303A4615Full,
                                                   0xA0F2EC75A1FE1575ull, 0x89E182857D9ED689ull};  // of 2⁶⁴
  const auto stream = static_cast<std::uint32_t>(2 * patch);
  const auto a = random_uniform(kSeed, stream, shift), b = random_uniform(kSeed, stream + 1, shift);
  std::array<double, 4> point = {a[0], a[1], b[0], b[1]};
  for (std::size_t d = 0; d < 4; ++d) {
    point[d] += static_cast<double>((k * kSteps[d]) >> 11) * 0x1p-53;
    point[d] -= std::floor(point[d]);
  }
  return point;
}

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

std::size_t klems_opposite(std::size_t patch) {
  const std::size_t ring = ring_of(patch), first = first_patch(ring),
                    patches = static_cast<std::size_t>(kKlemsRings[ring].patches);
  return first + (patch - first + patches / 2) % patches;
}

KlemsMatrix klems_matrix(const AnyBrdf& model, const std::vector<double>& lambda_um,
                         const std::vector<double>& weights, std::uint64_t draws) {
  assert(lambda_um.size() == weights.size() && draws >= kShifts);
  const double drawn_at = lambda_um[lambda_um.size() / 2];
  // ∫∫ f cosθ dω cosθ dω over patches of viewer and light, by light's.
  std::vector<double> light(kKlemsPatches * kKlemsPatches);
  std::vector<double> errors(kKlemsPatches);
  parallel_for(static_cast<std::int64_t>(kKlemsPatches), [&](std::int64_t n) {
    const auto column = static_cast<std::size_t>(n);
    const double share = klems_projected_solid_angle(column) / static_cast<double>(draws);
    std::array<double, kShifts> albedos{};
    for (std::uint64_t k = 0; k < draws; ++k) {
      const std::uint64_t shift = k % kShifts;
      const std::array<double, 4> xi = lattice_point(k / kShifts, column, shift);
      const Vec3 gone = drawn_in(column, {xi[0], xi[1]});
      const Vec3 wi(-gone.x(), -gone.y(), gone.z());
      const auto draw = model.sample(wi, drawn_at, {xi[2], xi[3]});
      if (!draw || !(draw->wo.z() > 0)) continue;
      double f = 0;
      for (std::size_t c = 0; c < lambda_um.size(); ++c)
        f += weights[c] * model.f(wi, draw->wo, lambda_um[c]);
      const double value = f * draw->wo.z() / draw->pdf;
      light[klems_patch(draw->wo) * kKlemsPatches + column] += share * value;
      albedos[shift] += value * kShifts / static_cast<double>(draws);
    }
    double mean = 0, squares = 0;
    for (const double value : albedos)
      mean += value / kShifts;
    for (const double value : albedos)
      squares += (value - mean) * (value - mean);
    errors[column] = std::sqrt(squares / (kShifts * (kShifts - 1.)));
  });
  // By reciprocity what goes from one patch to another goes back as well: rays both ways are pooled.
  KlemsMatrix matrix{std::vector<double>(kKlemsPatches * kKlemsPatches),
                     *std::max_element(errors.begin(), errors.end())};
  for (std::size_t row = 0; row < kKlemsPatches; ++row)
    for (std::size_t column = 0; column < kKlemsPatches; ++column) {
      const std::size_t back = klems_opposite(column) * kKlemsPatches + klems_opposite(row);
      const double to = klems_projected_solid_angle(row), from = klems_projected_solid_angle(column);
      matrix.f[row * kKlemsPatches + column] =
          (light[row * kKlemsPatches + column] / from + light[back] / to) / (from + to);
    }
  return matrix;
}

}  // namespace micro
