#include "height/make_holes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/random.h"

namespace micro {
namespace {

/// Streams of random numbers that no maker of surfaces uses.
enum Stream : std::uint32_t { kPoints = 0x686f6c65, kDiscs };

void take_points(Grid<double>& z, double fraction, std::uint64_t seed) {
  for (Eigen::Index k = 0; k < z.size(); ++k)
    if (random_uniform(seed, kPoints, static_cast<std::uint64_t>(k))[0] < fraction) z(k) = kMissing;
}

void take_disc(Grid<double>& z, const HeightField& surface, double x, double y, double radius) {
  const auto first = [](double t) {
    return std::max<Eigen::Index>(static_cast<Eigen::Index>(std::ceil(t)), 0);
  };
  for (Eigen::Index j = first((y - radius) / surface.dy); j < z.rows(); ++j) {
    const double dy = static_cast<double>(j) * surface.dy - y;
    if (dy > radius) break;
    const double half = std::sqrt(std::max(radius * radius - dy * dy, 0.));
    for (Eigen::Index i = first((x - half) / surface.dx); i < z.cols(); ++i) {
      if (static_cast<double>(i) * surface.dx > x + half) break;
      z(j, i) = kMissing;
    }
  }
}

void take_discs(Grid<double>& z, const HeightField& surface, const Holes& holes, std::uint64_t seed) {
  const double r = holes.radius;
  const double width = static_cast<double>(z.cols()) * surface.dx + 2 * r;
  const double height = static_cast<double>(z.rows()) * surface.dy + 2 * r;
  // A Poisson process on the patch and a margin: exponential steps along y, uniform along x.
  const double per_step = -std::log1p(-holes.fraction) / (std::numbers::pi * r * r) * width;
  double y = 0;
  for (std::uint64_t k = 0;; ++k) {
    const auto place = random_uniform(seed, kDiscs, k);
    y -= std::log(place[0]) / per_step;
    if (!(y < height)) return;
    take_disc(z, surface, place[1] * width - r, y - r, r);
  }
}

}  // namespace

HeightField make_holes(const HeightField& surface, const Holes& holes, std::uint64_t seed) {
  if (!(holes.fraction >= 0 && holes.fraction <= 1))
    throw InputError("the fraction of holes must lie between 0 and 1");
  if (holes.fraction == 0) return surface;
  Grid<double> z = surface.z.cast<double>() + surface.mean;
  if (holes.radius != 0 &&
      !(holes.radius >= 0.5 * std::min(surface.dx, surface.dy) && std::isfinite(holes.radius)))
    throw InputError("a hole's radius must be 0 or at least half the pitch");
  if (holes.fraction == 1)
    z.setConstant(kMissing);
  else if (holes.radius == 0)
    take_points(z, holes.fraction, seed);
  else
    take_discs(z, surface, holes, seed);
  return make_height_field(z, surface.dx, surface.dy);
}

}  // namespace micro
