#include "brdf/albedo.h"

#include <array>
#include <cmath>
#include <numbers>

#include "core/parallel.h"
#include "core/random.h"

namespace micro {
namespace {

constexpr int kShifts = 16;
constexpr std::uint64_t kFirst = 32, kMost = std::uint64_t{1} << 18;  // draws a shift
constexpr std::uint64_t kSeed = 5;
constexpr std::uint32_t kShiftStream = 0, kDirectionStream = 1, kPointStream = 2;

/// Point k of the lattice of multiples of (1/p, 1/p²), p³ = p + 1 the plastic number, which fills the square
/// evenly whatever the number of points [Roberts18, "The unreasonable effectiveness of quasirandom
/// sequences"].
Vec2 lattice_point(std::uint64_t k, const std::array<double, 2>& shift) {
  constexpr std::uint64_t kX = 0xC13FA9A902A6328Full, kY = 0x91E10DA5C79E7B1Dull;  // of 2^64
  const double x = static_cast<double>((k * kX) >> 11) * 0x1p-53 + shift[0];
  const double y = static_cast<double>((k * kY) >> 11) * 0x1p-53 + shift[1];
  return {x - std::floor(x), y - std::floor(y)};
}

}  // namespace

namespace detail {

Estimate<double> mean_weight(const SampleWeight& weight, double tolerance) {
  const Stopwatch watch;
  std::array<double, kShifts> sum{};
  std::uint64_t done = 0;
  double mean = 0, error = 0;
  for (std::uint64_t n = kFirst; n <= kMost; n *= 2) {
    parallel_for(kShifts, [&](std::int64_t s) {
      const auto shift = random_uniform(kSeed, kShiftStream, static_cast<std::uint64_t>(s));
      for (std::uint64_t k = done; k < n; ++k)
        sum[static_cast<std::size_t>(s)] += weight(lattice_point(k, shift));
    });
    done = n;
    mean = 0;
    for (const double total : sum)
      mean += total / static_cast<double>(n) / kShifts;
    double squares = 0;
    for (const double total : sum)
      squares += std::pow(total / static_cast<double>(n) - mean, 2);
    error = 2 * std::sqrt(squares / (kShifts * (kShifts - 1)));
    if (error <= tolerance) break;
  }
  return {mean, error, {watch.seconds(), static_cast<std::int64_t>(done) * kShifts}};
}

Vec3 random_direction(std::uint64_t k) {
  const auto [z, turn] = random_uniform(kSeed, kDirectionStream, k);
  const double sine = std::sqrt(1 - z * z), phi = 2 * std::numbers::pi * turn;
  return {sine * std::cos(phi), sine * std::sin(phi), z};
}

Vec2 random_point(std::uint64_t k) {
  const auto [x, y] = random_uniform(kSeed, kPointStream, k);
  return {x, y};
}

}  // namespace detail

double WhiteFurnace::most() const {
  double most = 0;
  for (const auto& a : albedo)
    if (!(a.value - a.error <= most)) most = a.value - a.error;
  return most;
}

std::vector<Vec3> furnace_directions() {
  constexpr std::array kDegrees = {15., 30., 45., 60., 75., 85., 89., 89.9, 89.999};
  std::vector<Vec3> directions = {{0, 0, 1}};
  for (const double degrees : kDegrees) {
    const double sine = std::sin(degrees * std::numbers::pi / 180);
    const double cosine = std::sin((90 - degrees) * std::numbers::pi / 180);
    for (const Vec2& azimuth : {Vec2(1, 0), Vec2(0, 1), Vec2(-1, 0), Vec2(0, -1)})
      directions.emplace_back(sine * azimuth.x(), sine * azimuth.y(), cosine);
  }
  return directions;
}

}  // namespace micro
