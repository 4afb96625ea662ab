#include "kirchhoff/kirchhoff_volume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "core/error.h"
#include "core/random.h"
#include "height/triangles.h"
#include "kirchhoff/exact.h"
#include "testing/cosine_surface.h"

namespace micro {
namespace {

using testing::make_gaussian_surface;
using testing::with_missing;

constexpr int kDirections = 400;
constexpr double kTol = 1e-4;
/// What density_volume.h states.
constexpr double kInterpolation = 5e-4;

/// Random q of the extent, both hemispheres.
Vec3 random_q(const VolumeExtent& extent, std::uint64_t index) {
  const auto u = random_uniform(7, 7, index), v = random_uniform(7, 8, index);
  return {(2 * u[0] - 1) * extent.q_xy, (2 * u[1] - 1) * extent.q_xy, (2 * v[0] - 1) * extent.q_z};
}

/// Relative L2 error at random q, and the largest error against the root mean square of D.
struct Measured {
  double l2, worst;
};

Measured measure(const DensityVolume& volume, const std::function<double(const Vec3&)>& exact) {
  double difference = 0, total = 0, worst = 0;
  for (std::uint64_t n = 0; n < kDirections; ++n) {
    const Vec3 q = random_q(volume.extent(), n);
    const double want = exact(q), d = volume(q) - want;
    difference += d * d;
    total += want * want;
    worst = std::max(worst, std::abs(d));
  }
  return {std::sqrt(difference / total), worst / std::sqrt(total / kDirections)};
}

TEST(KirchhoffVolume, EqualsExactAtRandomWaveVectors) {
  for (const HeightField& surface :
       {make_gaussian_surface({.rows = 40, .cols = 50}, 1),
        with_missing(make_gaussian_surface({.rows = 40, .cols = 50, .rms = 0.5}, 2), 0.1, 3)}) {
    const DensityVolume volume = kirchhoff_volume(surface, 10, 20, kTol);
    const Measured m = measure(volume, [&](const Vec3& q) { return exact_density(surface, q); });
    EXPECT_LE(m.l2, kInterpolation);
    EXPECT_LE(m.worst, 10 * kInterpolation);
  }
}

TEST(KirchhoffVolume, ServesEveryWavelength) {
  const HeightField surface = make_gaussian_surface({.rows = 30, .cols = 40}, 4);
  const double highest = 4 * std::numbers::pi / 0.4;
  const DensityVolume volume = kirchhoff_volume(surface, highest / 2, highest, kTol);
  for (const double lambda_q : {0.4, 0.55, 0.7}) {
    double difference = 0, total = 0;
    for (int n = 0; n < 60; ++n) {
      const auto u = random_uniform(3, 5, static_cast<std::uint64_t>(n));
      const double hx = 0.7 * (u[0] - 0.5), hy = 0.7 * (u[1] - 0.5);
      const Vec3 q = wave_vector(Vec3(hx, hy, std::sqrt(1 - hx * hx - hy * hy)), lambda_q);
      const double want = exact_density(surface, q), d = volume(q) - want;
      difference += d * d;
      total += want * want;
    }
    EXPECT_LE(std::sqrt(difference / total), kInterpolation) << lambda_q;
  }
}

TEST(KirchhoffVolume, FlatPatchIsASinc) {
  const HeightField plate = make_height_field(Grid<double>::Zero(20, 30), 0.2, 0.2);
  const DensityVolume volume = kirchhoff_volume(plate, 8, 20, kTol);
  const Measured m = measure(volume, [&](const Vec3& q) { return exact_density(plate, q); });
  EXPECT_LE(m.l2, 3e-3);
}

TEST(KirchhoffVolume, MeansOverPatchesAreMeansOfVolumes) {
  const HeightField first = make_gaussian_surface({.rows = 30, .cols = 40}, 5),
                    second = make_gaussian_surface({.rows = 24, .cols = 33}, 6);
  VolumeExtent extent = kirchhoff_extent(first, 6, 15);
  extent.height = std::max(extent.height, kirchhoff_extent(second, 6, 15).height);
  DensityVolume mean(extent), one(extent);
  const double areas[] = {projected_area(first), projected_area(second)};
  fill_with_kirchhoff(first, kTol, one);
  mean.add(one, areas[0]);
  fill_with_kirchhoff(second, kTol, one);
  mean.add(one, areas[1]);
  mean.scale(1 / (areas[0] + areas[1]));
  const Measured m = measure(mean, [&](const Vec3& q) {
    return (areas[0] * exact_density(first, q) + areas[1] * exact_density(second, q)) / (areas[0] + areas[1]);
  });
  EXPECT_LE(m.l2, kInterpolation);
}

TEST(KirchhoffVolume, RefusesWhatItCannotResolve) {
  const HeightField surface = make_gaussian_surface({.rows = 20, .cols = 20}, 8);
  DensityVolume small({1, 1, 1, 5, 10});
  EXPECT_THROW(fill_with_kirchhoff(surface, kTol, small), InputError);
  EXPECT_THROW(small(Vec3(6, 0, 1)), InputError);
  EXPECT_THROW(small(Vec3(0, 0, 11)), InputError);
  EXPECT_THROW(small(Vec3(0, std::nan(""), 1)), InputError);
  EXPECT_THROW(DensityVolume({1000, 1000, 10, 30, 30}), InputError);
  EXPECT_THROW(DensityVolume({0, 1, 1, 5, 5}), InputError);
  EXPECT_THROW(DensityVolume({1, 1, 1, std::nan(""), 5}), InputError);
  DensityVolume other({2, 1, 1, 5, 10});
  EXPECT_THROW(small.add(other, 1), InputError);
}

}  // namespace
}  // namespace micro
